"""What a run prints, with the times at which it came."""

from __future__ import annotations

import re
import subprocess
import threading
import time
from typing import NamedTuple

PATIENCE_S = 180.0


class Line(NamedTuple):
    """`when_s` is monotonic time."""

    when_s: float
    text: str


class Screen:
    """Reads the stdout of a run from a thread, until it ends."""

    def __init__(self, run: subprocess.Popen[bytes]) -> None:
        self.lines: list[Line] = []
        self._has_ended = False
        self._changed = threading.Condition()
        threading.Thread(target=self._read, args=(run,), daemon=True).start()

    def await_lines(self, pattern: str, count: int = 1, since_s: float = 0.0) -> list[Line]:
        """Wait for so many lines with the pattern; RuntimeError with what came instead."""
        found: list[Line] = []
        expected, begun_s = re.compile(pattern), time.monotonic()
        with self._changed:
            self._changed.wait_for(lambda: self._has(expected, count, since_s, found), PATIENCE_S)
        if len(found) < count:
            text = "\n".join(line.text for line in self.lines[-40:])
            waited_s = time.monotonic() - begun_s
            raise RuntimeError(
                f"{len(found)} of {count} lines with '{pattern}' after {waited_s:.0f} s:\n{text}"
            )
        return found

    def _has(
        self, expected: re.Pattern[str], count: int, since_s: float, found: list[Line]
    ) -> bool:
        lines = (line for line in self.lines if line.when_s >= since_s)
        found[:] = [line for line in lines if expected.search(line.text)]
        return len(found) >= count or self._has_ended

    def _read(self, run: subprocess.Popen[bytes]) -> None:
        assert run.stdout is not None
        for line in iter(run.stdout.readline, b""):
            with self._changed:
                text = line.decode(errors="replace").rstrip("\n")
                self.lines.append(Line(time.monotonic(), text))
                self._changed.notify_all()
        with self._changed:
            self._has_ended = True
            self._changed.notify_all()
