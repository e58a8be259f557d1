"""Signals as each member sees them: its own handlers, and those of rclpy.

Python has one handler for a signal, which runs in the main thread. Here that is the group's, which
calls the handlers of the members; an exception that one of these raises goes to the thread of its
member.
"""

from __future__ import annotations

import ctypes
import signal
import sys
import threading
from collections.abc import Callable
from typing import Any

from launcher.ros.composed import current
from launcher.ros.composed.member import Member

_own_signal, _own_getsignal = signal.signal, signal.getsignal
_OF_THE_PROCESS = ("pause", "sigwait", "sigtimedwait", "set_wakeup_fd")
_SENT_BY = {
    signal.ITIMER_REAL: signal.SIGALRM,
    signal.ITIMER_VIRTUAL: signal.SIGVTALRM,
    signal.ITIMER_PROF: signal.SIGPROF,
}

_AGAIN_S = 0.02
_IMPORTING_S = 3.0  # a program may do all its work while it is imported

Forward = Callable[[int], None]


def install(forward: Forward) -> None:
    """From now on `signal.signal` of a member sets a handler of that member.

    `forward(signum)` delivers a signal to the process, in its main thread.
    """

    def set_handler(signum: int, handler: Any) -> Any:
        one = current.member()
        if one is None:
            return _own_signal(signum, handler)
        before = handler_of(one, signum)
        one.handlers[signum] = handler
        if callable(handler):
            forward(signum)
        return before

    def get_handler(signum: int) -> Any:
        one = current.member()
        return _own_getsignal(signum) if one is None else handler_of(one, signum)

    signal.signal, signal.getsignal = set_handler, get_handler  # type: ignore[assignment]
    for name in _OF_THE_PROCESS:
        setattr(signal, name, _refusing(name, getattr(signal, name)))
    refuse_alarm = _refusing("alarm", signal.alarm)
    refuse_timer = _refusing("setitimer", signal.setitimer)

    def alarm(seconds: int) -> Any:
        return 0 if _is_limit(signal.SIGALRM) else refuse_alarm(seconds)

    def set_timer(which: int, seconds: float, interval_s: float = 0.0) -> Any:
        is_limit = which in _SENT_BY and _is_limit(_SENT_BY[which])
        return (0.0, 0.0) if is_limit else refuse_timer(which, seconds, interval_s)

    signal.alarm, signal.setitimer = alarm, set_timer
    sys.unraisablehook = _repeating(sys.unraisablehook)


def _repeating(report: Callable[[Any], Any]) -> Callable[[Any], None]:
    """Interrupt a member again if the exception came in a destructor, which drops it.

    Not at once: it would be raised here, and dropped once more.
    """

    def hook(unraisable: Any) -> None:
        one, kind = current.member(), unraisable.exc_type
        if one is None or kind not in (KeyboardInterrupt, SystemExit):
            report(unraisable)
        else:
            _later(one, kind, _IMPORTING_S)

    return hook


def _refusing(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    def call(*arguments: object) -> Any:
        if current.member() is None:
            return function(*arguments)
        raise RuntimeError(f"signal.{name} does not work in a composed node: it is of the process")

    return call


def _is_limit(signum: int) -> bool:
    """Whether a timer with this signal would end the member: the group limits its end itself."""
    one = current.member()
    return one is not None and not callable(handler_of(one, signum))


def handler_of(one: Member, signum: int) -> Any:
    default = signal.default_int_handler if signum == signal.SIGINT else signal.SIG_DFL
    return one.handlers.get(signum, default)


def deliver(one: Member, signum: int) -> None:
    """What the signal would do to the member if it were a process."""
    if one.has_ended:
        return
    shuts_down = one.rclpy_shuts_down_at(signum)
    handler = handler_of(one, signum)
    if handler == signal.SIG_DFL and not shuts_down and signum in (signal.SIGTERM, signal.SIGHUP):
        interrupt(one, SystemExit)
        one.killed_by = signum
    elif callable(handler):
        try:
            with current.acting_as(one):
                handler(signum, sys._current_frames().get(one.ident))
        except BaseException as error:
            interrupt(one, type(error))
            if isinstance(error, KeyboardInterrupt):
                one.is_interrupted = True
    if shuts_down:  # last, or its thread could see this before the exception
        one.end_contexts()
    one.wake()


def interrupt(one: Member, kind: type[BaseException], patience_s: float = _IMPORTING_S) -> None:
    """Raise it in the thread of the member, as soon as that executes Python.

    After an import, if it is within one: the lock of imports could stay taken, on which the imports
    of all other members wait.
    """
    if patience_s > 0 and _is_importing(one):
        _later(one, kind, patience_s - _AGAIN_S)
        return
    with one.lock:
        if not one.has_ended:
            ctypes.pythonapi.PyThreadState_SetAsyncExc(
                ctypes.c_ulong(one.ident), ctypes.py_object(kind)
            )


def _later(one: Member, kind: type[BaseException], patience_s: float) -> None:
    timer = threading.Timer(_AGAIN_S, interrupt, (one, kind, patience_s))
    timer.daemon = True
    timer.start()


def _is_importing(one: Member) -> bool:
    frame = sys._current_frames().get(one.ident)
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False
