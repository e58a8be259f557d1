"""Run ROS 2 launch files from pip: start, supervise and steer the processes of a robot system."""

__version__ = "0.1.0"
