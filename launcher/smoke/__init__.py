"""Smoke: a launch file as a test. Starts a system as a user would, looks at it from outside,
takes it down, and says whether what was expected was seen.

Never imports rclpy: a process of its own looks at the ROS graph (`launcher.ros.probe`).
"""

from launcher.smoke.observed import NotSeenError
from launcher.smoke.system import System

__all__ = ["NotSeenError", "System"]
