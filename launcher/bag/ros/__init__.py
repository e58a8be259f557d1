"""Recording and playing bags: what of `bag` needs ROS."""
