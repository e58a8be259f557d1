"""The ROS side of a smoke test, a separate process: `python -m launcher.ros.probe`.

It reads requests from standard input and writes answers and what it observes of its domain to
standard output, a JSON object a line, and ends with its input. docs/reference/probe.md lists both.

It does not disturb the system: its nodes are hidden, and its subscriptions keep the last messages
only, so that a publisher never waits for it.
"""
