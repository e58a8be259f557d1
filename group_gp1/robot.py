"""robot: any robot of a warehouse; the name of its node is its id."""

from __future__ import annotations

from group_gp1 import runner
from group_gp1.nodes.robot_node import Robot, RobotProfile
import rclpy
from rclpy.executors import ExternalShutdownException

ANY_ROBOT = RobotProfile(robot_id=None, task_duration_s=1.0)


def main(args: list[str] | None = None) -> None:
    """Run a robot with the name of its node as its id, until SIGINT or SIGTERM."""
    try:
        runner.run(lambda: Robot(ANY_ROBOT), args)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the usual exit; the node is already destroyed
    finally:
        if rclpy.ok():
            rclpy.try_shutdown()


if __name__ == '__main__':
    main()
