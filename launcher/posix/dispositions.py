"""Signals: what is taken over from the parent process, what is respected, and what children get.

Ignored and blocked signals are inherited through exec. Cron, CI agents and tool runners ignore
SIGCHLD, nohup SIGHUP, and a shell without job control SIGINT and SIGQUIT of what it starts with
`&`. docs/reference/running.md has the table. The watchdog uses this: its rules for imports apply.
"""

from __future__ import annotations

import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    import signal
    from collections.abc import Callable, Iterable
    from types import FrameType

    Handler = Callable[[int, FrameType | None], object]
else:
    import _signal as signal  # see `posix.cleanup.watchdog`

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
# Python ignores these, and what is exec'd would do so, too.
OF_PYTHON = (signal.SIGPIPE, signal.SIGXFSZ)
EVERY = frozenset(signal.valid_signals())
_AGAIN_S = 0.02  # by then, Python has left the destructor; otherwise it is repeated once more


def take_over() -> None:
    """To be called first in a program: it has children, and can be signalled, as any other."""
    notice_children()
    # What is pending arrives now.
    signal.pthread_sigmask(signal.SIG_SETMASK, ())


def notice_children() -> None:
    """Let the ends of children be noticed: with SIGCHLD ignored, their exit codes are lost.

    ValueError outside of the main thread, if it is ignored.
    """
    if _is_ignored(signal.SIGCHLD):
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)


def heeded(signums: Iterable[int] = ENDING) -> list[int]:
    """Without SIGHUP if that is ignored, since nohup asks to outlive the terminal."""
    return [one for one in signums if one != signal.SIGHUP or not _is_ignored(one)]


class Handled:
    """Within, `handler` has those of these signals that are heeded; in the main thread."""

    def __init__(self, handler: Handler | int, signums: Iterable[int] = ENDING) -> None:
        self._handler = handler if callable(handler) else int(handler)
        self._signums = signums
        self._before: dict[int, Handler | int | None] = {}

    def __enter__(self) -> None:
        for signum in heeded(self._signums):
            self._before[signum] = signal.signal(signum, self._handler)

    def __exit__(self, *exc: object) -> None:
        for signum, before in self._before.items():
            signal.signal(signum, signal.SIG_DFL if before is None else before)


class RaisedBySignal(BaseException):
    """What a handler raises to leave all blocks in order, as KeyboardInterrupt does for SIGINT."""

    def __init__(self, signum: int) -> None:
        super().__init__(signum)
        self.signum = signum


def repeat_dropped_signals() -> None:
    """Send a signal again whose exception Python drops.

    It prints `Exception ignored in` and goes on where that is raised in a destructor or the
    callback of a weak reference, such as each import has: a Ctrl-C meanwhile would be lost.
    """
    report = sys.unraisablehook

    def repeat(dropped: sys.UnraisableHookArgs) -> None:
        if issubclass(dropped.exc_type, KeyboardInterrupt):
            _send_later(signal.SIGINT)
        elif isinstance(dropped.exc_value, RaisedBySignal):
            _send_later(dropped.exc_value.signum)
        else:
            report(dropped)

    sys.unraisablehook = repeat


def _send_later(signum: int) -> None:
    """Send it to this thread, where exceptions of handlers are raised.

    Now, it would be raised in `sys.unraisablehook`, and be dropped once more.
    """
    import _thread
    import time

    def send(thread: int) -> None:
        time.sleep(_AGAIN_S)
        signal.pthread_kill(thread, signum)

    _thread.start_new_thread(send, (_thread.get_ident(),))


class Endable(Handled):
    """Within, Ctrl-C and SIGTERM end the process: Python handles none in a `sum(range(10**12))`.

    For expressions of users. Does nothing in other threads than the main one.
    """

    def __init__(self) -> None:
        super().__init__(signal.SIG_DFL, (signal.SIGINT, signal.SIGTERM))

    def __enter__(self) -> None:
        try:
            super().__enter__()
        except ValueError:  # another thread
            self._before.clear()


def ignore(signums: Iterable[int] = ENDING) -> None:
    """Ignore signals in a helper process: those that stop a run are for its other processes."""
    for signum in signums:
        signal.signal(signum, signal.SIG_IGN)


def for_exec() -> Handled:
    """Within, what Python has set for itself is undone, before another program is exec'd."""
    return Handled(signal.SIG_DFL, OF_PYTHON)


def are_default() -> bool:
    """Whether a program that subprocess starts ignores and blocks nothing."""
    ignored = any(map(_is_ignored, EVERY.difference(OF_PYTHON)))
    return not ignored and not signal.pthread_sigmask(signal.SIG_BLOCK, ())


def reset() -> None:
    """Ignore and block nothing, between fork and exec."""
    for signum in filter(_is_ignored, EVERY):
        signal.signal(signum, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_SETMASK, ())


def _is_ignored(signum: int) -> bool:
    return signal.getsignal(signum) == signal.SIG_IGN
