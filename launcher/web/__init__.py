"""The page in the browser: a process of its own, a client of a run and of the probe.

`server` composes it. It does not import rclpy; what is known of the ROS graph comes from the probe.
"""
