"""Interruption: what asks a smoke command to stop its system and end, and with which exit code."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator
from types import FrameType

from launcher.errors import ExitCode

_SIGNALS = (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)


class Terminated(KeyboardInterrupt):
    """A signal other than Ctrl-C; handled as that, but told apart in the end."""


def code_of(interrupt: KeyboardInterrupt) -> ExitCode:
    """130 for Ctrl-C, 143 for the others."""
    return ExitCode.TERMINATED if isinstance(interrupt, Terminated) else ExitCode.INTERRUPTED


@contextlib.contextmanager
def terminable() -> Iterator[None]:
    """SIGTERM, SIGHUP and SIGQUIT stop the system, as Ctrl-C does."""

    def interrupt(signum: int, frame: FrameType | None) -> None:
        raise Terminated

    before = {signum: signal.signal(signum, interrupt) for signum in _SIGNALS}
    try:
        yield
    finally:
        for signum, handler in before.items():
            signal.signal(signum, handler)
