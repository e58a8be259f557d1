"""Helper processes of a run that need rclpy; the supervisor's side is `launcher.run.helpers`.

* `agent`: lifecycle transitions and components, which launch files may request. An event or an
  answer may be lost: then it asks for the node's state (`lifecycle_client`), or for the
  container's nodes (`component_client`). It also has the timers on the ROS clock of a simulation.
* `parameter_check` compares parameters with what nodes declare; `logger_levels` asks nodes for the
  levels of their loggers; both end then.
* `responsiveness` asks nodes once a second whether they answer; one for each domain.
* `bridge` (`--ros`) is a client of the control socket that publishes `diagnostics`.
* `clean_up`: the end of a process with nodes. `spinning_node`: the node of a script that asks for
  it.
"""
