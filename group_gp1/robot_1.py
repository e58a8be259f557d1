"""robot_1, the normal robot: 0.5 seconds per task."""

from __future__ import annotations

from group_gp1 import runner
from group_gp1.nodes.robot_node import Robot, RobotProfile
import rclpy
from rclpy.executors import ExternalShutdownException

PROFILE = RobotProfile(robot_id='robot_1', task_duration_s=0.5)


def main(args: list[str] | None = None) -> None:
    """Run robot_1 until SIGINT or SIGTERM."""
    try:
        runner.run(lambda: Robot(PROFILE), args)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the usual exit; the node is already destroyed
    finally:
        if rclpy.ok():
            rclpy.try_shutdown()


if __name__ == '__main__':
    main()
