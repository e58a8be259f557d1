"""Runs a launch file with real processes, in one thread with one event loop.

May import `base`, `posix`, `packages`, `output` and `language`; never rclpy, which brings threads
and signal handlers, and never rich or prompt_toolkit. What needs these is a helper process.

Pure state machines decide, with time as an argument, and drivers act:

* `run` has what everything in a run shares; `supervisor` begins and ends it. A feature of a run is
  a `part`, with a row in the table `parts`, and perhaps verbs in `part_verbs`.
* `byte_code_notice` says once that Python compiles modules at every start.
* `core_driver` feeds the interpreter with events and carries out its effects; `launch_timers` are
  those of the launch file; `ros_requests`: what launch files ask of nodes.

Folders:

* `processes/`: start, stop and restart of a process. `starts/`: stages that hold a start back.
  `requests/`: requests of users for processes, in which order they are carried out. `ending/`: the
  end of a run, exit codes, leftovers; `launcher.posix.cleanup` has the watchdog. `reload/`: what a
  new evaluation changes. `debug/`: a process under debugpy.
* `ready/`: first starts wait for others. `warm/`: Python nodes forked from a process that has
  imported what they need. `watch/`: files that processes have loaded. `compose/`: several nodes in
  one process. `monitor/`: resources and budgets. `stacks/`: what threads are doing.
* `output/`: the reader of pipes, and what is shown of each process. `logs/`: log files, messages
  of the launcher, the summary at the end.
* `helpers/`: the engine's side of the helper processes.

Restarts, lines and the first start come before everything else: what may wait is done in idle
moments of the reactor, one import or task in each pass.
"""
