"""ROS packages, their executables, and colcon workspaces: where they are, without running them."""
