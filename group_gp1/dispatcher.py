"""The dispatcher: assigns tasks to the robots in turn."""

from __future__ import annotations

import uuid

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import String

from group_gp1 import qos, runner, settings, topics
from group_gp1.rotation import Rotation


class Dispatcher(Node):
    """Publishes one assignment per tick on `/fleet/tasks`."""

    def __init__(self) -> None:
        super().__init__("dispatcher")
        rate_hz = settings.number(
            self, "dispatch_rate_hz", 1.0, low=0.01, high=1000.0, unit="Hz", about="Assignments"
        )
        robot_ids = settings.names(
            self,
            "robot_ids",
            ["robot_1", "robot_2", "robot_3"],
            about="Robots that get tasks, in this order",
        )
        depth = settings.whole_number(
            self,
            "task_history_depth",
            qos.TASKS_DEPTH,
            low=1,
            high=qos.MAX_DEPTH,
            unit="messages",
            about="Assignments kept for robots that join late",
        )
        # the run makes task ids unique after a restart, when the dispatcher counts from 1 again
        self._rotation = Rotation(robot_ids, run=uuid.uuid4().hex[:8])
        self._tasks = self.create_publisher(String, topics.TASKS, qos.tasks_profile(depth))
        self._timer = self.create_timer(1.0 / rate_hz, self._dispatch)

    def _dispatch(self) -> None:
        assignment = self._rotation.next()
        self._tasks.publish(String(data=assignment.to_json()))
        self.get_logger().info(f"Assigned task {assignment.task} to {assignment.robot_id}")


def main(args: list[str] | None = None) -> None:
    """Run the dispatcher until SIGINT or SIGTERM."""
    try:
        runner.run(Dispatcher, args)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the usual exit; the node is already destroyed
    finally:
        if rclpy.ok():
            rclpy.try_shutdown()


if __name__ == "__main__":
    main()
