"""Launched: the launcher as a child, from outside: started, signalled, waited for, killed."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

KILL_S = 5.0  # between SIGTERM and SIGKILL


class LauncherProcess:
    """`python -m launcher WORDS`, without a terminal, in a session of its own.

    What it prints goes to the file `output`. A Ctrl-C in our terminal does not reach it. If we are
    killed, a guard stops it.
    """

    def __init__(self, words: Sequence[str], environment: Mapping[str, str], output: Path) -> None:
        self.output = output
        with output.open("wb") as file:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "launcher", *words],
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                env=dict(environment),
                start_new_session=True,
            )
        self._guard = Watchdog(self._process.pid)
        self._was_killed = False

    @property
    def pid(self) -> int:
        """Its pid, by which its run is found."""
        return self._process.pid

    @property
    def is_alive(self) -> bool:
        """Whether it runs."""
        return self._process.poll() is None

    @property
    def returncode(self) -> int | None:
        """Its exit code; None if it runs, or had to be killed."""
        return None if self._was_killed else self._process.poll()

    def wait(self, within_s: float) -> bool:
        """Whether it has ended within this time."""
        try:
            self._process.wait(max(0.0, within_s))
        except subprocess.TimeoutExpired:
            return False
        return True

    def stop(self, patience_s: float) -> None:
        """As Ctrl-C does; then SIGTERM, then SIGKILL. It has ended afterwards."""
        if self.is_alive:
            self._process.send_signal(signal.SIGINT)
        if not self.wait(patience_s):
            self._force()
        self._guard.close()

    def _force(self) -> None:
        self._process.send_signal(signal.SIGCONT)  # somebody may have halted it
        self._process.send_signal(signal.SIGTERM)
        if not self.wait(KILL_S):
            self._was_killed = True
            self._process.kill()
            self._process.wait()

    def last_words(self, count: int) -> list[str]:
        """The last lines that it printed."""
        with contextlib.suppress(OSError):
            return self.output.read_text(encoding="utf-8", errors="replace").splitlines()[-count:]
        return []


GOODBYE = b"."
PATIENCE_S = 30.0  # an orderly stop with all its escalations
GOODBYE_S = 2.0


class Watchdog:
    """Our end of it, for a launcher that runs; `close()` when the launcher has ended."""

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
        """All is over; more than once does no harm."""
        assert self._process.stdin is not None
        if self._process.stdin.closed:
            return
        try:
            self._process.stdin.write(GOODBYE)
        except BrokenPipeError:
            pass  # somebody killed it
        finally:
            self._process.stdin.close()
        try:
            self._process.wait(GOODBYE_S)
        except subprocess.TimeoutExpired:  # somebody has stopped it
            self._process.kill()
            self._process.wait()


def _end(launcher: int) -> None:
    """As Ctrl-C, then with force; what the launcher had started, its own watchdog ends."""
    signal.pidfd_send_signal(launcher, signal.SIGINT)
    ended, _, _ = select.select([launcher], [], [], PATIENCE_S)
    if not ended:
        signal.pidfd_send_signal(launcher, signal.SIGKILL)


def main() -> None:
    """Wait for the end of standard input."""
    for signum in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(signum, signal.SIG_IGN)
    try:
        launcher = os.pidfd_open(int(sys.argv[1]))
    except ProcessLookupError:
        return  # it was over before we were up
    if os.read(0, 1) != GOODBYE:
        _end(launcher)


if __name__ == "__main__":
    main()
