"""A process that tells a run which facts of the ROS graph hold."""
