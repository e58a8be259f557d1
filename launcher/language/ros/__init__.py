"""ROS nodes: the names of `launch_ros`."""
