"""The launcher as a child process, and a watchdog that stops it if this process is killed.

The watchdog is this file run as a script with `-I -S`, so that it does not depend on site-packages.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

KILL_S = 5.0  # between SIGTERM and SIGKILL
WATCHDOG_STOP_S = 30.0  # an orderly stop with all its escalations
WATCHDOG_EXIT_S = 2.0
DONE = b"."
FORECAST = "LAUNCHER_FORECAST"  # the variable of the launcher


class LauncherProcess:
    """`python -m launcher WORDS` without a terminal, in a new session.

    Its output goes to the file `output`. Ctrl-C in the terminal does not reach it. With `foresees`,
    it starts nothing before its `forecast` was read and `go_on` was called.
    """

    module = "launcher"

    def __init__(
        self,
        words: Sequence[str],
        environment: Mapping[str, str],
        output: Path,
        *,
        foresees: bool = False,
    ) -> None:
        from launcher.posix import dispositions  # the watchdog cannot import it

        self._output = output
        with contextlib.suppress(ValueError):  # in a thread of pytest
            dispositions.notice_children()
        self._judge: socket.socket | None = None
        with contextlib.ExitStack() as stack:
            file = stack.enter_context(output.open("wb"))
            passed: list[int] = []
            environment = dict(environment)
            if foresees:
                self._judge, theirs = socket.socketpair()
                passed = [stack.enter_context(theirs).fileno()]
                environment[FORECAST] = str(passed[0])
            self._process = subprocess.Popen(
                [sys.executable, "-m", self.module, *words],
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                env=environment,
                start_new_session=True,
                pass_fds=passed,
            )
        self._watchdog = Watchdog(self._process.pid)
        self._was_killed = False

    @property
    def pid(self) -> int:
        return self._process.pid

    def forecast(self, within_s: float) -> Any:
        """What it will start; None if it ends before, or takes too long to read the launch file."""
        from launcher.base import strict_json  # the watchdog cannot import it

        assert self._judge is not None
        self._judge.settimeout(within_s)
        with contextlib.suppress(OSError, ValueError), self._judge.makefile("rb") as answer:
            return strict_json.unpacked(answer.readline())
        return None

    def go_on(self) -> None:
        assert self._judge is not None
        with contextlib.suppress(OSError):  # it has ended
            self._judge.sendall(DONE)

    @property
    def is_alive(self) -> bool:
        return self._process.poll() is None

    @property
    def returncode(self) -> int | None:
        """Its exit code; None while it runs, or if it had to be killed."""
        return None if self._was_killed else self._process.poll()

    def stop(self, grace_s: float) -> None:
        """SIGINT, after `grace_s` SIGTERM, then SIGKILL; returns when it has exited."""
        if self.is_alive:
            self._process.send_signal(signal.SIGINT)
        if self._judge is not None:
            self._judge.close()
        if not _wait(self._process, grace_s):
            self._process.send_signal(signal.SIGCONT)  # it may have been suspended
            self._process.send_signal(signal.SIGTERM)
            if not _wait(self._process, KILL_S):
                self._was_killed = True
                self._process.kill()
                self._process.wait()
        self._watchdog.close()

    def last_lines(self, count: int) -> list[str]:
        """Of its output, as a terminal would show them."""
        from launcher.output.lines import for_terminal  # the watchdog has no packages

        with contextlib.suppress(OSError):
            lines = for_terminal(self._output.read_bytes()).removesuffix(b"\n")
            return lines.decode(errors="replace").split("\n")[-count:]
        return []


def _wait(process: subprocess.Popen[bytes], within_s: float) -> bool:
    """Whether it exits within this time."""
    try:
        process.wait(max(0.0, within_s))
    except subprocess.TimeoutExpired:
        return False
    return True


class Watchdog:
    """Stops the launcher when its pipe is closed without the byte of `close()`."""

    def __init__(self, launcher_pid: int) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", os.path.abspath(__file__), str(launcher_pid)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            cwd="/",
            start_new_session=True,
            bufsize=0,
        )

    def close(self) -> None:
        """The launcher has exited; may be called more than once."""
        assert self._process.stdin is not None
        if self._process.stdin.closed:
            return
        try:
            self._process.stdin.write(DONE)
        except BrokenPipeError:
            pass  # it was killed
        finally:
            self._process.stdin.close()
        if not _wait(self._process, WATCHDOG_EXIT_S):  # it was suspended
            self._process.kill()
            self._process.wait()


def main() -> None:
    """The watchdog: wait for the end of standard input."""
    for signum in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(signum, signal.SIG_IGN)
    try:
        launcher = os.pidfd_open(int(sys.argv[1]))
    except ProcessLookupError:
        return  # it has already exited
    if os.read(0, 1) == DONE:
        return
    # Processes that outlive the launcher are killed by its own watchdog.
    signal.pidfd_send_signal(launcher, signal.SIGINT)
    exited, _, _ = select.select([launcher], [], [], WATCHDOG_STOP_S)
    if not exited:
        signal.pidfd_send_signal(launcher, signal.SIGKILL)


if __name__ == "__main__":
    main()
