"""Pattern: a regular expression of a person's, which must not hold up a run."""

from __future__ import annotations

import re
import signal
from collections.abc import Sequence
from types import FrameType

PATIENCE_S = 0.1  # of computing, for one block of lines; 64 KiB take a hundredth of that


class TooSlowError(Exception):
    """Finding it takes too long."""


class Pattern:
    """Finds lines, or gives up: some expressions take for ever on some lines (`(a+)+$`).

    `text` is as it was written; re.error if it cannot be read.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self._expression = re.compile(text.encode(errors="surrogateescape"))
        self._is_at_work = False

    def choose(self, lines: Sequence[bytes]) -> list[bytes]:
        """The lines in which it is found; TooSlowError. For the main thread alone.

        Python looks for signals while it searches, and a timer counts what we compute.
        """
        before = signal.signal(signal.SIGVTALRM, self._struck)
        self._is_at_work = True
        signal.setitimer(signal.ITIMER_VIRTUAL, PATIENCE_S)
        try:
            return [line for line in lines if self._expression.search(line)]
        finally:
            self._is_at_work = False
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)
            signal.signal(signal.SIGVTALRM, before)

    def _struck(self, signum: int, frame: FrameType | None) -> None:
        if self._is_at_work:
            raise TooSlowError(self.text)
