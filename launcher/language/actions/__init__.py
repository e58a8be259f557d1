"""Actions (`launch.actions`), except those of ROS nodes."""
