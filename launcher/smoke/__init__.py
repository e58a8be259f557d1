"""Smoke tests of launch files: start a system, observe it from outside, stop it, judge.

Never imports rclpy: a process of its own observes ROS (`launcher.ros.probe`).
"""

from launcher.smoke.run.system import System
from launcher.smoke.run.waits import NotSeenError

__all__ = ["NotSeenError", "System"]
