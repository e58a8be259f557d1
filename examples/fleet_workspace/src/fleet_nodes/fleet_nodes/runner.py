"""Runs a node until Ctrl-C or SIGTERM."""

from __future__ import annotations

import signal
from collections.abc import Callable
from typing import TypeVar

import rclpy
from rclpy.executors import Executor, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

_LOOK_S = 0.2  # maximum delay of a stop

AnyNode = TypeVar("AnyNode", bound=Node)


class WaitingExecutor(MultiThreadedExecutor):
    """Its `shutdown` waits for callbacks that run; that of ROS 2 Jazzy may not (ros2/rclpy#893).

    Without it they would use nodes and a context that do not exist any more.
    """

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        self._executor.shutdown()
        return super().shutdown(timeout_sec)


def run(
    make_node: Callable[[], AnyNode],
    args: list[str] | None = None,
    *,
    make_executor: Callable[[], Executor] = SingleThreadedExecutor,
    stop: Callable[[AnyNode], bool] = lambda _: True,
) -> None:
    """Spin one node until Ctrl-C or SIGTERM, and then until `stop` says that its work has ended.

    The signals only set a flag: rclpy's own handlers would shut the context down while callbacks
    still publish.
    """
    stops: list[int] = []
    for signum in (signal.SIGINT, signal.SIGTERM):
        signal.signal(signum, lambda number, _: stops.append(number))
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    try:
        node, executor = make_node(), make_executor()
        executor.add_node(node)
        while not (stops and stop(node)):
            executor.spin_once(timeout_sec=_LOOK_S)
        executor.shutdown()
    finally:
        rclpy.try_shutdown()
