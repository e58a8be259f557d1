"""The graph from discovery messages of RTPS, without DDS; with rclpy where that is not possible.

`rtps` and `endpoints` read packets, `participant` and `discovery_reader` take part in discovery;
`prefetch` reads while rclpy is imported, `observer` is the node of rclpy, `completeness` says when
all is known. `follower` and `graph_changes` follow a graph; `graph_server` and `graph_socket` share
that of a run. `run_settings` finds nodes as the run on the domain does; `introductions`, a part of
runs, lets new nodes discover those that run already; `reannounce` asks participants whose answer to
ours was lost; `stale_nodes`: nodes that rmw lists although their participant has gone.
"""
