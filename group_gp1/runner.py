"""The life of a node process: init, construct, spin, clean up, on every way out.

A stop is asked for by SIGINT or SIGTERM, and both mean the same. A Python handler takes note, and
raises nothing, so that no KeyboardInterrupt can burst into a destructor or the clean-up. rclpy's
own handlers (in C, they call ours as well) shut the context down, which ends the spinning. They
are installed when the node stands, because half a node in a dead context complains.
"""

from __future__ import annotations

import signal
import time
from collections.abc import Callable
from types import FrameType

import rclpy
from rclpy.exceptions import InvalidHandle, NotInitializedException
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions, install_signal_handlers

from group_gp1.settings import SettingError

_STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_NAP_S = 0.05  # how late a sleeper may notice the stop
_LOOK_S = 0.5  # how late a node that waits for messages may notice it at worst

# What rclpy raises where it is used after its context went down.
_AFTER_SHUTDOWN = (rclpy_implementation.RCLError, InvalidHandle, NotInitializedException)


class _StopNote:
    """A signal handler that remembers the stop and raises nothing."""

    def __init__(self) -> None:
        self.asked = False

    def __call__(self, signum: int, frame: FrameType | None) -> None:
        self.asked = True


def run(
    make_node: Callable[[], Node],
    args: list[str] | None = None,
    *,
    make_executor: Callable[[], Executor] = SingleThreadedExecutor,
) -> None:
    """Spin one node until SIGINT or SIGTERM.

    Returns or raises ExternalShutdownException, as the executor does; SystemExit with a sentence
    where the arguments or a parameter are wrong. The node is destroyed in every case; shutting
    the context down where it is still up is left to the caller. For the main thread only.
    """
    stop = _StopNote()
    for signum in _STOP_SIGNALS:
        signal.signal(signum, stop)
    try:
        _init(args)
        _spin(make_node, make_executor, stop)
    except SettingError as error:
        raise SystemExit(f"error: {error}") from None
    except _AFTER_SHUTDOWN:
        if rclpy.ok():
            raise
        raise ExternalShutdownException from None  # a stop in the middle of something
    finally:
        for signum in _STOP_SIGNALS:  # the end has begun: a second Ctrl-C must not tear it
            signal.signal(signum, signal.SIG_IGN)


def nap(duration_s: float) -> bool:
    """Sleep, but not beyond a stop; tells whether the time was slept in full.

    A plain sleep would hold back the end of the process for its whole length.
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
    except (rclpy_implementation.RCLError, rclpy_implementation.UnknownROSArgsError) as error:
        raise SystemExit(f"error: {error}") from None


def _spin(
    make_node: Callable[[], Node], make_executor: Callable[[], Executor], stop: _StopNote
) -> None:
    node = make_node()
    try:
        executor = make_executor()
        executor.add_node(node)
        install_signal_handlers(SignalHandlerOptions.ALL)
        # A stop may have come before those handlers. Seen once in some forty runs: one that comes
        # between two waits wakes nobody up, and a node without timers goes on waiting.
        while rclpy.ok() and not stop.asked:
            executor.spin_once(timeout_sec=_LOOK_S)
    finally:
        node.destroy_node()
