"""The side of a run of its helper processes.

Each is started only when it is needed, exchanges lines of JSON (`json_lines`), and nothing waits
for it. On their side these have a separate descriptor, since Fast DDS prints to standard output.

* `ros_agent` (`launcher.ros.helpers.agent`): lifecycle transitions, components, and the timers on
  the ROS clock of a simulation. `launcher.run.ros_requests` answers requests whose node has exited.
* `parameter_checks`: compares parameters with what nodes declare. `namesake_checks`: nodes of
  others that have the names of ours. `warning_helpers` is what the two share.
* `logger_levels`: the verb `loglevel`. `graph_facts` (`launcher.ros.ready`): facts of
  `ready_when`, with rclpy only where a fact needs a node.
* `launcher.run.watch`: which processes have loaded a file that has changed.
* `client_process`: programs that are clients of the control socket, and outlive a killed launcher:
  the bridge (`--ros`), the server of the page (`--web`). `answering_process`: those that also
  answer requests of the run, the flight recorder (`--record`) and the watcher of faults.

The console gets the launcher's output through a pipe once it is ready; until then the supervisor
writes to the terminal. It is in the launcher's process group, so that Ctrl-Z and `fg` apply to
both, and does not have the run's id: it outlives a killed launcher long enough to restore the
terminal. Conversely the launcher keeps the terminal settings and the other end of the pipe.
"""
