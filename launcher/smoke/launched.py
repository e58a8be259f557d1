"""Launched: the launcher as a child, from outside: started, signalled, waited for, killed."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from launcher.smoke.guard import Guard

KILL_S = 5.0  # between SIGTERM and SIGKILL


class Launched:
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
        self._guard = Guard(self._process.pid)
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
