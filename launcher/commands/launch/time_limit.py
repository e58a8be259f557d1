"""Patience: how long the evaluation of a launch file may take."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
from collections.abc import Iterator
from types import FrameType

from launcher.errors import ExitCode, LaunchFileError
from launcher.language.diagnostics.origin import Origin
from launcher.model.record import Record

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, NoReturn

_AGAIN_S = 1.0  # a launch file that catches everything is interrupted again
_ATTEMPTS = 3  # then the launcher ends at once; nothing was started yet


class TimeLimit(Record):
    """Seconds that an evaluation may take, 0 for any time.

    `wall_s` is for launch files that wait for something that never comes; `cpu_s`, the time of
    this process on a processor, for those that loop.
    """

    wall_s: float = 60.0
    cpu_s: float = 20.0


class _Endless(BaseException):
    """Raised in the middle of an evaluation; no `except Exception` may stop it."""

    ros_type = "TimeoutError"
    _launcher_origin: Origin | None = None  # see launcher.language.diagnostics.faults


@contextlib.contextmanager
def limited(time_limit: TimeLimit, path: str) -> Iterator[None]:
    """Interrupt the body when the limit is reached: LaunchFileError with the place.

    Does nothing in other threads than the main one, which cannot be interrupted.
    """
    # Where nobody has imported `threading`, there is only one thread.
    threading = sys.modules.get("threading")
    if threading is not None and threading.current_thread() is not threading.main_thread():
        yield
        return
    try:
        with (
            _timer(signal.ITIMER_REAL, signal.SIGALRM, time_limit.wall_s, "s have passed", path),
            _timer(signal.ITIMER_PROF, signal.SIGPROF, time_limit.cpu_s, "s were computed", path),
        ):
            yield
    except _Endless as error:
        raise _explained(error, path) from error


@contextlib.contextmanager
def _timer(
    which: int, signum: signal.Signals, limit_s: float, what: str, path: str
) -> Iterator[None]:
    if not limit_s:
        yield
        return

    interruptions = 0

    def interrupt(signum: int, frame: FrameType | None) -> None:
        nonlocal interruptions
        interruptions += 1
        error = _Endless(f"the launch file does not come to an end: {limit_s:g} {what}")
        error._launcher_origin = _place_in(path, frame)
        if interruptions > _ATTEMPTS:
            _end_at_once(error, path)
        raise error

    before: Any = signal.signal(signum, interrupt)
    signal.setitimer(which, limit_s, _AGAIN_S)
    try:
        yield
    finally:
        signal.setitimer(which, 0)
        signal.signal(signum, before)


def _place_in(path: str, frame: FrameType | None) -> Origin | None:
    """The line of the launch file that is being executed."""
    while frame is not None:
        if frame.f_code.co_filename == path:
            return Origin(path, frame.f_lineno)
        frame = frame.f_back
    return None


def _end_at_once(error: _Endless, path: str) -> NoReturn:
    print(_explained(error, path).render(), file=sys.stderr, flush=True)
    os._exit(ExitCode.USAGE)


def _explained(error: _Endless, path: str) -> LaunchFileError:
    from launcher.language.diagnostics import faults

    fault = faults.explain(error, path)
    fault.hint = "--evaluation-timeout S allows more time, 0 any time"
    return fault
