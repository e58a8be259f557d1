"""A ROS node that a thread spins, for scripts that run a LaunchService."""

from __future__ import annotations

import atexit
import os
import threading
from collections.abc import Sequence

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from launcher.posix.stdio import stdout_to_stderr


class SpinningNode:
    """The node `launch_ros_PID`, in a separate context and without signal handlers."""

    def __init__(self, argv: Sequence[str] = ()) -> None:
        self.context = Context()
        rclpy.init(
            args=list(argv),
            context=self.context,
            signal_handler_options=SignalHandlerOptions.NO,
        )
        with stdout_to_stderr():  # Fast DDS prints warnings about a new participant to stdout
            self.node = rclpy.create_node(f"launch_ros_{os.getpid()}", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self._thread = threading.Thread(target=self.executor.spin, name="launch_ros", daemon=True)
        self._thread.start()
        atexit.register(self.close)  # a spinning thread crashes in a library that is unloaded

    def close(self) -> None:
        """Destroy the node, after the callback that runs; RuntimeError from a callback."""
        if threading.current_thread() is self._thread:
            raise RuntimeError("a callback of the ROS adapter's node cannot shut the adapter down")
        atexit.unregister(self.close)
        self.executor.shutdown()
        self._thread.join()
        self.node.destroy_node()
        self.context.try_shutdown()
