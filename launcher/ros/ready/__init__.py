"""A process that reports which facts of the ROS graph hold: `python -m launcher.ros.ready`.

It looks by discovery messages (`views`), and with rclpy only where a fact needs a node
(`node_facts`); `graph_conditions` are what it may be asked. The supervisor's side is
`launcher.run.helpers.graph_facts`.
"""
