"""Runs a launch file with real processes, in one thread with one event loop.

May import `base`, `posix`, `packages`, `output` and `language`; never rclpy, which brings threads
and signal handlers, and never rich or prompt_toolkit. What needs these is a helper process.

Pure state machines decide, with time as an argument, and drivers act:

* `machine` and `process_driver`: start, stop and restart of a process. `request_queue` and
  `process_control`: requests of users for a process, in which order they are carried out.
* `shutdown_machine` and `shutdown`: the end of a run, exit codes; `leftovers` and `session_end`:
  what processes leave behind. `launcher.posix.cleanup` has the watchdog.
* `core_driver` feeds the interpreter with events and carries out its effects; `timers` are those
  of the launch file; `start_pacing` holds starts back until their turn; `reload` carries out what
  a new evaluation of the launch file changes; `ros_requests`: what launch files ask of nodes.
* `supervisor` composes a run.

Folders:

* `ready/`: first starts wait for others. `warm/`: Python nodes forked from a process that has
  imported what they need. `watch/`: files that processes have loaded. `compose/`: several nodes in
  one process. `monitor/`: resources and budgets. `stacks/`: what threads are doing.
* `output/`: the reader of pipes, and what is shown of each process. `logs/`: log files, messages
  of the launcher, the summary at the end.
* `helpers/`: the engine's side of the helper processes.

Restarts, lines and the first start come before everything else: what may wait is done in idle
moments of the reactor, one import or task in each pass.
"""
