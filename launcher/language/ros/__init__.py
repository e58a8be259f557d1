"""The part of the language that knows ROS nodes: what `launch_ros` offers."""
