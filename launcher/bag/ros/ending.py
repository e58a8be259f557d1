"""Ctrl-C, SIGTERM and SIGHUP while a bag is recorded or played."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from launcher.posix.dispositions import heeded

GIVE_UP_S = 2.0
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextmanager
def ending(*, interrupts: bool) -> Iterator[Callable[[], bool]]:
    """Whether a signal came. With `interrupts` the first one raises KeyboardInterrupt.

    The terminal and a program around this one may send one each, so that those of the next
    `GIVE_UP_S` are the same wish; then another one interrupts the finishing. After the end they are
    ignored: there is nothing left to end, and the exit code stays.
    """
    first_s: float | None = None

    def handle(number: int, frame: object) -> None:
        nonlocal first_s
        now = time.monotonic()
        if first_s is None:
            first_s = now
            if interrupts:
                raise KeyboardInterrupt
        elif now - first_s > GIVE_UP_S:
            raise KeyboardInterrupt

    before = {one: signal.signal(one, handle) for one in heeded(_SIGNALS)}
    try:
        yield lambda: first_s is not None
    finally:
        for signum, handler in before.items():
            signal.signal(signum, handler if first_s is None else signal.SIG_IGN)
