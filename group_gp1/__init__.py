"""
A small warehouse fleet: dispatcher, robots, monitor, and two diagnostic nodes.

Each of the modules dispatcher, monitor, debug_logger, qos_probe, robot and robot_1 to robot_3 is
an entry point, whose `main` runs one node. The classes of the nodes are in `nodes/`; what needs no
rclpy is in `logic/`.
"""
