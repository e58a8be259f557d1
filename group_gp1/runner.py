"""
Runs a node: init, construct, spin, clean up, however it ends.

SIGINT and SIGTERM both request a stop. A Python handler sets a flag and raises nothing, so that no
KeyboardInterrupt can occur in a destructor or in the clean-up. rclpy's own handlers (in C; they
call the Python ones, too) shut the context down, which ends the spin. They are installed when the
node exists, because constructing a node in a context that is shut down fails with errors.
"""

from __future__ import annotations

from collections.abc import Callable
import signal
import time
from types import FrameType

from group_gp1.settings import SettingError
import rclpy
from rclpy.exceptions import InvalidParameterTypeException, NotInitializedException
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos_overriding_options import InvalidQosOverridesError
from rclpy.signals import install_signal_handlers, SignalHandlerOptions

_STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_NAP_S = 0.05  # maximum delay of a stop during nap()
_LOOK_S = 0.5  # maximum delay of a stop that did not wake the executor
# Limits for the destruction of a node, which takes 0.05 s. `ros2 launch` and the launcher kill a
# node 10 s after SIGINT.
_CLEAN_UP_CPU_S = 2.0
_CLEAN_UP_S = 8.0

# What rclpy raises if it is used after the shutdown of its context. Its errors in C, such as
# InvalidHandle, are RuntimeErrors, and most have no public name.
_AFTER_SHUTDOWN = (RuntimeError, NotInitializedException)


class _StopNote:
    """A signal handler that sets a flag and raises nothing."""

    def __init__(self) -> None:
        self.requested = False

    def __call__(self, signum: int, frame: FrameType | None) -> None:
        self.requested = True


def run(
    make_node: Callable[[], Node],
    args: list[str] | None = None,
    *,
    make_executor: Callable[[], Executor] = SingleThreadedExecutor,
) -> None:
    """
    Spin one node until SIGINT or SIGTERM.

    Returns or raises ExternalShutdownException, as the executor does; raises SystemExit with a
    message if the arguments or a parameter are invalid. The node is always destroyed; the caller
    shuts the context down if that has not happened. For the main thread only. If the destruction
    hangs, the process dies of SIGPROF or SIGALRM.
    """
    stop = _StopNote()
    for signum in _STOP_SIGNALS:
        signal.signal(signum, stop)
    try:
        _init(args)
        _spin(make_node, make_executor, stop)
    except (SettingError, InvalidQosOverridesError, InvalidParameterTypeException) as error:
        raise SystemExit(f'error: {error}') from None
    except _AFTER_SHUTDOWN:
        if rclpy.ok():
            raise
        raise ExternalShutdownException from None  # a stop during construction or a callback
    finally:
        for signum in _STOP_SIGNALS:  # a second Ctrl-C must not interrupt the clean-up
            signal.signal(signum, signal.SIG_IGN)


def nap(duration_s: float) -> bool:
    """
    Sleep, but return early on a stop; returns whether the time has passed.

    A plain sleep would delay the exit of the process.
    """
    deadline_s = time.monotonic() + duration_s
    while rclpy.ok():
        left_s = deadline_s - time.monotonic()
        if left_s <= 0:
            return True
        time.sleep(min(left_s, _NAP_S))
    return False


def _init(args: list[str] | None) -> None:
    try:
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:  # what rclpy raises for --ros-args has no public name
        raise SystemExit(f'error: {error}') from None


def _spin(
    make_node: Callable[[], Node], make_executor: Callable[[], Executor], stop: _StopNote
) -> None:
    node = make_node()
    try:
        executor = make_executor()
        executor.add_node(node)
        install_signal_handlers(SignalHandlerOptions.ALL)
        # A stop may have been requested before those handlers were installed. In about one of
        # forty runs, a signal between two waits does not wake an executor without timers.
        while rclpy.ok() and not stop.requested:
            executor.spin_once(timeout_sec=_LOOK_S)
    finally:
        # Fast DDS may loop here for ever, with the GIL held, if another participant leaves just
        # then (eProsima/Fast-DDS#6513), or wait for ever for a lock. The default action of a
        # signal ends the process.
        signal.setitimer(signal.ITIMER_PROF, _CLEAN_UP_CPU_S)
        signal.setitimer(signal.ITIMER_REAL, _CLEAN_UP_S)
        try:
            node.destroy_node()
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
            signal.setitimer(signal.ITIMER_REAL, 0)
