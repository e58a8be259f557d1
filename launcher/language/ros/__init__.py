"""`launch_ros`: nodes, lifecycle, composition, parameters."""
