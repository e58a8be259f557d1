"""Signals that end a build."""

from __future__ import annotations

import contextlib
import signal
import sys
from collections.abc import Iterator
from types import FrameType

from launcher.base.errors import ExitCode
from launcher.posix.dispositions import Handled, RaisedBySignal

_ENDING = (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)


class BuildTerminated(RaisedBySignal):
    """SIGTERM, SIGHUP or SIGQUIT; Ctrl-C is a KeyboardInterrupt."""


@contextlib.contextmanager
def end_the_build() -> Iterator[None]:
    """Raise BuildTerminated for them, so that blocks are left in order."""

    def end(number: int, _: FrameType | None) -> None:
        raise BuildTerminated(number)

    with Handled(end, _ENDING):
        yield


def interrupted(stop: BaseException, note: str) -> ExitCode:
    """Print what an interruption means for the user; its exit code."""
    with contextlib.suppress(OSError):  # the terminal was closed
        print(f"\ninterrupted: {note}", file=sys.stderr, flush=True)
    return ExitCode.INTERRUPTED if isinstance(stop, KeyboardInterrupt) else ExitCode.TERMINATED


@contextlib.contextmanager
def ignored() -> Iterator[None]:
    """Ignore them and Ctrl-C: what is done takes no time."""
    with Handled(signal.SIG_IGN):
        yield
