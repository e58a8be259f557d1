"""A server that shows a ROS graph to Foxglove and to Lichtblick: the verb `foxglove`.

It speaks the WebSocket protocol of Foxglove itself. The WebSocket server of foxglove-sdk for
Python deadlocks if a topic or the connection graph changes while a client subscribes: it waits
for its locks with the GIL held, and calls Python with its locks held.
"""
