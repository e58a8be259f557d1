"""Signals that end a build."""

from __future__ import annotations

import contextlib
import signal
import sys
from collections.abc import Iterator
from types import FrameType

from launcher.errors import ExitCode

_ENDING = (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)


class Terminated(BaseException):
    """SIGTERM, SIGHUP or SIGQUIT; Ctrl-C is a KeyboardInterrupt."""


@contextlib.contextmanager
def end_the_build() -> Iterator[None]:
    """Raise Terminated for them, so that blocks are left in order.

    What the parent ignores, as nohup does with SIGHUP, is ignored.
    """

    def end(number: int, _: FrameType | None) -> None:
        raise Terminated(number)

    heeded = [one for one in _ENDING if signal.getsignal(one) is not signal.SIG_IGN]
    handlers = {number: signal.signal(number, end) for number in heeded}
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)


def interrupted(stop: BaseException, note: str) -> ExitCode:
    """Print what an interruption means for the user; its exit code."""
    with contextlib.suppress(OSError):  # the terminal was closed
        print(f"\ninterrupted: {note}", file=sys.stderr, flush=True)
    return ExitCode.INTERRUPTED if isinstance(stop, KeyboardInterrupt) else ExitCode.TERMINATED


@contextlib.contextmanager
def ignored() -> Iterator[None]:
    """Ignore them and Ctrl-C: what is done takes no time."""
    handlers = {
        number: signal.signal(number, signal.SIG_IGN) for number in (*_ENDING, signal.SIGINT)
    }
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
