"""The programs that are compared: how launcher and reference run a list of commands."""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, NamedTuple

from benchmarks.harness import NotHereError

REPOSITORY = Path(__file__).resolve().parents[1]
REFERENCE = Path(__file__).with_name("reference.py")
RUN_TIMEOUT_S = 120.0  # a run that takes longer has failed

_LAUNCH_FILE = """from launch import LaunchDescription
from launch.actions import ExecuteProcess


def generate_launch_description():
    return LaunchDescription([
        ExecuteProcess(cmd=command, output="screen", **{options!r})
        for command in {commands!r}
    ])
"""


class Work(NamedTuple):
    """The commands to run, and where; `folder` is empty and private to this run."""

    folder: Path
    commands: Sequence[Sequence[str]]
    pty: bool = False
    respawn: bool = False


class Contestant(NamedTuple):
    """A name, and a function from the work to the command line."""

    name: str
    command: Callable[[Work], list[str]]
    environment: Callable[[Work], Mapping[str, str]]

    @contextmanager
    def running(self, work: Work, stdout: IO[bytes] | int) -> Iterator[subprocess.Popen[bytes]]:
        """Run the work; all its processes are stopped when the block ends."""
        process = subprocess.Popen(
            self.command(work),
            cwd=REPOSITORY,
            env=dict(self.environment(work)),
            stdin=subprocess.DEVNULL,
            stdout=stdout,
        )
        try:
            yield process
        finally:
            end(process)


def wait_for_end(
    process: subprocess.Popen[bytes], meanwhile: Callable[[int], object] = lambda pid: None
) -> int:
    """Wait for the exit without delay: `Popen.wait(timeout)` polls only every 50 ms.

    `meanwhile` is called with the pid when it has exited and is not reaped yet.
    """
    pidfd = os.pidfd_open(process.pid)
    try:
        poll = select.poll()
        poll.register(pidfd, select.POLLIN)
        if not poll.poll(RUN_TIMEOUT_S * 1000):
            raise TimeoutError(f"still running after {RUN_TIMEOUT_S:g} s: {process.args!r}")
        meanwhile(process.pid)
    finally:
        os.close(pidfd)
    return process.wait()


def end(process: subprocess.Popen[bytes]) -> None:
    """Stop a run in order if it still runs, else kill it; its children exit with it."""
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(RUN_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def python_environment() -> dict[str, str]:
    """The environment, but with cached byte code, so that compilation is not measured."""
    unwanted = ("PYTHONDONTWRITEBYTECODE", "NO_COLOR", "FORCE_COLOR")
    return {name: value for name, value in os.environ.items() if name not in unwanted}


def shell_environment() -> dict[str, str]:
    """The same without what the hook of the wheels has set for this process."""
    of_hook = ("_ROS_WHEELS_BOOTSTRAP_COMPLETE", "LD_LIBRARY_PATH")
    return {name: value for name, value in python_environment().items() if name not in of_hook}


def python_s(*words: str, folder: Path = REPOSITORY) -> float:
    """Seconds from the start of a Python program to its end; CalledProcessError."""
    begun = time.monotonic()
    subprocess.run(
        [sys.executable, *words],
        env=python_environment(),
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        check=True,
    )
    return time.monotonic() - begun


def installed_command() -> str:
    """The command `launcher` of this environment; NotHereError."""
    command = Path(sys.executable).with_name("launcher")
    if not command.exists():
        raise NotHereError(f"{command} is not installed")
    return str(command)


def _launcher_command(work: Work, *words: str) -> list[str]:
    options: dict[str, object] = {}
    if work.pty:
        options["emulate_tty"] = True
    if work.respawn:
        options.update(respawn=True, respawn_delay=0.0)
    commands = [list(command) for command in work.commands]
    file = work.folder / "bench.launch.py"
    file.write_text(_LAUNCH_FILE.format(options=options, commands=commands), encoding="utf-8")
    return [sys.executable, "-m", "launcher", *words, str(file)]


def _reference_command(work: Work, mode: str = "prefix") -> list[str]:
    flags = ["--pty"] * work.pty + ["--respawn"] * work.respawn
    return [sys.executable, str(REFERENCE), mode, *flags, json.dumps(work.commands)]


def _with_log_files(work: Work) -> dict[str, str]:
    return {**python_environment(), "ROS_LOG_DIR": str(work.folder / "log")}


LAUNCHER = Contestant("launcher", _launcher_command, _with_log_files)
LAUNCHER_WITHOUT_LOGS = Contestant(
    "launcher, no log files",
    lambda work: _launcher_command(work, "--no-log-files"),
    lambda work: python_environment(),
)
PREFIXER = Contestant("prefixer", _reference_command, lambda work: python_environment())
SPAWN_LOOP = Contestant(
    "posix_spawn loop",
    lambda work: _reference_command(work, "spawn"),
    lambda work: python_environment(),
)
