"""Interrupts the evaluation of a launch file that takes too long."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
from collections.abc import Iterator
from types import FrameType

from launcher.base.errors import ExitCode, LaunchFileError
from launcher.base.model.record import Record
from launcher.language.diagnostics.origin import FileLine

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, NoReturn

_AGAIN_S = 1.0  # interrupt a launch file that catches all exceptions again
_ATTEMPTS = 3  # then the launcher exits at once; no process has been started yet


class TimeLimit(Record):
    """Seconds that an evaluation may take; 0 is no limit.

    `wall_s` catches launch files that wait forever, `cpu_s` (CPU time of this process) those that
    loop.
    """

    wall_s: float = 60.0
    cpu_s: float = 20.0


class _Endless(BaseException):
    """Raised in the middle of an evaluation; `except Exception` does not catch it."""

    ros_type = "TimeoutError"


@contextlib.contextmanager
def limited(time_limit: TimeLimit, path: str) -> Iterator[None]:
    """Interrupt the body when the limit is reached: LaunchFileError with the place.

    Does nothing in other threads than the main one, which cannot be interrupted.
    """
    # If `threading` has not been imported, there is only one thread.
    threading = sys.modules.get("threading")
    if threading is not None and threading.current_thread() is not threading.main_thread():
        yield
        return
    try:
        with (
            _timer(signal.ITIMER_REAL, signal.SIGALRM, time_limit.wall_s, "s", path),
            _timer(signal.ITIMER_PROF, signal.SIGPROF, time_limit.cpu_s, "s of CPU time", path),
        ):
            yield
    except _Endless as error:
        raise _explained(error, path) from error


@contextlib.contextmanager
def _timer(
    which: int, signum: signal.Signals, limit_s: float, unit: str, path: str
) -> Iterator[None]:
    if not limit_s:
        yield
        return

    interruptions = 0

    def interrupt(signum: int, frame: FrameType | None) -> None:
        nonlocal interruptions
        interruptions += 1
        error = _Endless(f"evaluating the launch file takes more than {limit_s:g} {unit}")
        if interruptions > _ATTEMPTS:
            _end_at_once(error, path, _place_in(path, frame))
        raise error

    before: Any = signal.signal(signum, interrupt)
    signal.setitimer(which, limit_s, _AGAIN_S)
    try:
        yield
    finally:
        signal.setitimer(which, 0)
        signal.signal(signum, before)


def _place_in(path: str, frame: FrameType | None) -> FileLine | None:
    """The line of the launch file that is being executed."""
    while frame is not None:
        if frame.f_code.co_filename == path:
            return FileLine(path, frame.f_lineno)
        frame = frame.f_back
    return None


def _end_at_once(error: _Endless, path: str, place: FileLine | None) -> NoReturn:
    from launcher.language.diagnostics.error_details import details

    details(error).place = place
    print(_explained(error, path).render(), file=sys.stderr, flush=True)
    os._exit(ExitCode.USAGE)


def _explained(error: _Endless, path: str) -> LaunchFileError:
    from launcher.language.diagnostics import faults

    fault = faults.explain(error, path)
    fault.hint = "--evaluation-timeout S raises the limit, 0 disables it"
    return fault
