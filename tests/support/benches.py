"""Fixtures of the process tests: small launch files, run by the real launcher."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import tempfile
import textwrap
import uuid
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TypeVar

import psutil
import pytest

from launcher.control.active_runs import wait_for_run
from launcher.hosts.engine import agent_link
from tests.support.controlled_run import ControlledRun
from tests.support.screen_terminal import ScreenTerminal
from tests.support.terminal import Terminal, marked_processes
from tests.support.watching import Desk

MARK = "LAUNCHER_TEST_MARK"
TIMEOUT_S = 120

HEAD = """
import sys
import tempfile
from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument, ExecuteProcess, LogDebug, LogInfo, OpaqueFunction, RegisterEventHandler,
    ReplaceEnvironmentVariables, Shutdown, TimerAction)
from launch.event_handlers import OnProcessExit, OnShutdown
from launch.substitutions import LaunchLogDir

def sh(script, **options):
    return ExecuteProcess(cmd=["sh", "-c", script], **{"output": "screen", **options})

def py(script, **options):
    return ExecuteProcess(cmd=[sys.executable, "-c", script], **{"output": "screen", **options})

def generate_launch_description():
    return LaunchDescription([
"""


class Bench:
    """Writes a launch file from the text of its actions, and runs it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.mark = uuid.uuid4().hex
        self.env = {
            **os.environ,
            "ROS_LOG_DIR": str(folder / "log"),
            "XDG_STATE_HOME": str(folder / "state"),
            "TERM": "xterm-256color",
            MARK: self.mark,
        }
        for name in ("NO_COLOR", "FORCE_COLOR"):
            self.env.pop(name, None)
        self.terminals: list[Terminal | ScreenTerminal] = []

    def command(self, actions: str, *words: str) -> Sequence[str]:
        file = self.folder / "bench.launch.py"
        file.write_text(f"{HEAD}{actions}\n    ])\n", encoding="utf-8")
        return [sys.executable, "-m", "launcher", str(file), *words]

    def run(self, actions: str, *words: str) -> subprocess.CompletedProcess[bytes]:
        """Run to the end, with standard output in a pipe."""
        return subprocess.run(
            self.command(actions, *words),
            env=self.env,
            capture_output=True,
            timeout=TIMEOUT_S,
            check=False,
        )

    def start(self, actions: str, *words: str) -> subprocess.Popen[bytes]:
        """Start with standard output in a pipe."""
        return subprocess.Popen(
            self.command(actions, *words),
            env=self.env,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )

    def terminal(self, actions: str, *words: str) -> Terminal:
        """Start in a terminal."""
        terminal = Terminal(self.command(actions, *words), env=self.env)
        self.terminals.append(terminal)
        return terminal

    def screen_terminal(
        self, actions: str, *words: str, columns: int = 100, rows: int = 24
    ) -> ScreenTerminal:
        """Start in a terminal whose screen can be read."""
        terminal = ScreenTerminal(
            self.command(actions, *words), env=self.env, columns=columns, rows=rows
        )
        self.terminals.append(terminal)
        return terminal

    def ask_run(self, run: int, *words: str) -> None:
        """Ask something of the run of this launcher, as from another shell."""
        verb, *rest = words
        wait_for_run(run, TIMEOUT_S)  # it listens a moment after its first process
        command = [sys.executable, "-m", "launcher", verb, "--run", str(run), *rest]
        subprocess.run(command, env=self.env, check=True, timeout=TIMEOUT_S, capture_output=True)

    def survivors(self) -> list[str]:
        """Command lines of what still runs of all that was started here."""
        return list(marked_processes(MARK, self.mark))

    def close(self) -> None:
        for process in marked_processes(MARK, self.mark).values():
            with contextlib.suppress(psutil.NoSuchProcess):
                process.kill()  # what the launcher left is just being ended by its guard
        for terminal in self.terminals:
            terminal.__exit__()


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    one = Bench(tmp_path)
    yield one
    one.close()


class ControlBench(Bench):
    """Runs launch files whose sockets are in a separate folder."""

    def __init__(self, folder: Path, runtime: Path) -> None:
        super().__init__(folder)
        self.runtime = runtime
        self.runs: list[ControlledRun] = []

    def launch(self, actions: str, *words: str, files: int | None = None) -> ControlledRun:
        run = ControlledRun(
            self.command(actions, *words),
            env=self.env,
            runtime=self.runtime,
            screen=self.folder / f"screen-{len(self.runs)}",
            files=files,
        )
        self.runs.append(run)
        return run

    def close(self) -> None:
        for run in self.runs:
            run.__exit__()
        super().close()


_AnyControlBench = TypeVar("_AnyControlBench", bound=ControlBench)


@contextlib.contextmanager
def bench_with_sockets(kind: type[_AnyControlBench], folder: Path) -> Iterator[_AnyControlBench]:
    # pytest's own folders have paths that are too long for sockets.
    with tempfile.TemporaryDirectory(prefix="run-") as runtime:
        one = kind(folder, Path(runtime))
        yield one
        one.close()


@pytest.fixture
def control_bench(tmp_path: Path) -> Iterator[ControlBench]:
    with bench_with_sockets(ControlBench, tmp_path) as one:
        yield one


class Workspace:
    """Writes launch files and calls the launcher; `started` exists if anything was started."""

    HEAD = """
import os, subprocess, sys
from launch import LaunchDescription
from launch.actions import *
from launch.conditions import *
from launch.substitutions import *

def generate_launch_description():
    return LaunchDescription([
"""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.started = folder / "started"
        self.env = {**os.environ, "ROS_LOG_DIR": str(folder / "log"), "TMPDIR": str(folder)}
        self.env.pop("FORCE_COLOR", None)

    def write(self, actions: str, name: str = "a.launch.py") -> Path:
        start = f'ExecuteProcess(cmd=["touch", "{self.started}"]),'
        body = textwrap.indent(textwrap.dedent(actions), "        ")
        (self.folder / name).write_text(f"{self.HEAD}        {start}\n{body}\n    ])\n")
        return self.folder / name

    def call(self, *words: str | Path, **env: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-m", "launcher", *map(str, words)],
            env={**self.env, **env},
            cwd=self.folder,
            capture_output=True,
            text=True,
            timeout=TIMEOUT_S,
            check=False,
        )

    def document(self, *words: str | Path) -> dict:
        done = self.call("plan", "--json", *words)
        assert done.returncode == 0, done.stderr
        document: dict = json.loads(done.stdout)
        return document


@pytest.fixture
def workspace(tmp_path: Path) -> Workspace:
    return Workspace(tmp_path)


@pytest.fixture
def run(control_bench: ControlBench) -> Iterator[ControlledRun]:
    """A run with one process, `cat-1`, which echoes its input."""
    with control_bench.launch('sh("exec cat", name="cat")') as one:
        yield one


@pytest.fixture
def desk(control_bench: ControlBench) -> Desk:
    return Desk(control_bench)


@pytest.fixture
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Links give an agent 60 s to answer, and to end: a busy machine may take long."""
    monkeypatch.setattr(agent_link, "CONNECT_S", 60.0)
    monkeypatch.setattr(agent_link, "LEAVE_S", 60.0)
