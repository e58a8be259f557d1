"""A limit of CPU time for searches with regular expressions of users."""

from __future__ import annotations

import signal

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import FrameType
    from typing import Any


class TooSlowError(Exception):
    """What was limited has used up its CPU time."""


class CpuLimit:
    """Within, TooSlowError after `max_cpu_s` of CPU time of this process, as `(a+)+$` takes.

    For the main thread only. Python handles signals while it searches, unlike in the middle of
    arithmetic.
    """

    def __init__(self, max_cpu_s: float) -> None:
        self._max_cpu_s = max_cpu_s
        self._is_at_work = False
        self._before: Any = None

    def __enter__(self) -> None:
        self._before = signal.signal(signal.SIGVTALRM, self._struck)
        self._is_at_work = True
        signal.setitimer(signal.ITIMER_VIRTUAL, self._max_cpu_s)

    def __exit__(self, *exc: object) -> None:
        self._is_at_work = False
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, self._before)

    def _struck(self, signum: int, frame: FrameType | None) -> None:
        if self._is_at_work:
            raise TooSlowError
