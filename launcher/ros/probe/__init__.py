"""The probe: the ROS side of a test, in a process of its own: `python -m launcher.ros.probe`.

It reads requests from standard input and tells on standard output what it sees of its domain, a
JSON object a line both ways, and ends with its input. docs/probe.md lists requests and events.

It does not disturb what it looks at: its nodes are hidden, and its subscriptions keep the last
messages only, so that a publisher never waits for it.
"""
