"""A server that shows a ROS graph to Foxglove and to Lichtblick: the verb `foxglove`.

It implements the WebSocket protocol of Foxglove itself. The WebSocket server of foxglove-sdk for
Python deadlocks if a topic or the connection graph changes while a client subscribes: it waits for
its locks with the GIL held, and calls Python with its locks held.

`verb` is its door; docs/guides/foxglove.md says what clients can do.

It is an asyncio loop with a thread for messages and one for answers of services:

* `foxglove_server` listens; `protocol` reads and writes messages. `client_session` is one client:
  what it subscribes and publishes, and what waits to be sent to it, bounded, since it may read
  slowly.
* `foxglove_bridge` brings clients and the graph together: `graph_view` is the graph at one moment,
  `catalogue` the channels and services on offer, under numbers that are never reused.
* `feeds` are subscriptions, which exist while clients need them and fit the publishers; `receiver`
  is the thread that takes their messages without decoding them. `publishing`: topics of clients.
* `service_calls`: services, whose answers rclpy's executor takes in a thread. `parameter_services`:
  those of all nodes as `/node.parameter`, and their changes.
"""
