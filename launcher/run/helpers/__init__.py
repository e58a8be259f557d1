"""The engine's side of the helper processes: console, ROS agent, ROS bridge, page and others.

Each is started only when it is needed, is spoken to by lines of JSON, and nothing waits for it.
The console gets the launcher's output through a pipe once it is ready; until then the supervisor
writes to the terminal. It is in the launcher's process group, so that Ctrl-Z and `fg` apply to
both, and does not have the run's id: it outlives a killed launcher long enough to restore the
terminal. Conversely the launcher keeps the terminal settings and the other end of the pipe.
"""
