"""A running ROS graph: reading, drawing, testing and using it.

May import the core and no other wing. With `bag`, the only room that imports rclpy: the
supervisor never does, since rclpy brings threads and signal handlers.

Doors:

* `verbs/`: one module per verb: `topic`, `node`, `param`, `service`, `action`, `lifecycle`,
  `interface`, `graph`, `tf`, `wait`, `multicast`, `daemon`. `verb` is what they share: options,
  access to the graph, output; `front` reads options in front of the verb.
* `node_tables`, `parameters`, `service_caller`, `goals` (of actions), `lifecycle_nodes`, `waiting`:
  what these verbs do.
* Processes: `helpers/`, `ready/`, `probe/` and `composed/`, started by runs, smoke and the page.

Folders:

* `discovery/`: the graph from discovery messages, without a node. `snapshot/`: the graph at one
  moment (`ros_graph`), what has changed (`diff`), whether QoS settings match (`qos_matching`).
* `messages/`: messages to and from YAML; classes of types, their definitions as one text
  (`message_schema`).
* `topics/`: listing, echo, publishing, statistics of topics.
* `tf/`: transforms between frames, without tf2.
* `foxglove/`: the verb `foxglove`, a server for Foxglove and Lichtblick.
* `draw/`: the graph as a tree, DOT and Mermaid; DOT is drawn by Graphviz as WebAssembly from PyPI.
"""
