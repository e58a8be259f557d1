"""What only the operating system makes necessary: the reactor, spawning, limits, /proc.

May import `base`. Everything that starts processes uses it: runs, tests, the agent on a host,
smoke.

Doors:

* `reactor`: the event loop, one thread for descriptors, timers and signals; `when_idle` runs what
  may come after the first processes, one task in each pass. It takes the place of asyncio, whose
  import takes longer than the start of a process.
* `spawn`: processes by `posix_spawn`, each the leader of its own session, held by a pidfd.
  `popen` starts those with a working directory, `pseudo_terminals` has what they write to if they
  ask for a terminal.
  `limits` starts those with `--nice`, `--cpus` or `--limit` through a small interpreter
  (`limits_exec`) that sets them and execs the program, or reports what was refused.
* `dispositions`: how inherited signals are handled (the table in docs/reference/running.md).
  Children begin with every signal at its default and none blocked.
* `open_files`: the limit of open files, raised for the launcher when half of it is used, and as
  before for its children.
* `proc`: the reader of `/proc/PID`. `tree_cpu_usage`: how busy a process and its descendants are.
  `stdio`: redirection of standard output by descriptors, and text printed to closed or narrow
  outputs; helper processes keep a separate descriptor for messages (`keep_for_messages`), since
  Fast DDS prints to standard output, and end with their input (`end_of_input`). `keys`: those that
  are typed, by name.
* `allocator`: memory that is freed is kept for the next large buffer. `write_behind`: files that
  are written once leave the page cache as they grow.
* `pipes`: those that hold more than usual.
* `log_folder`: a folder for logs that can be written. `socket_directory`: the private folder of
  sockets. `state_folder`: that of what is remembered of a user.
* `domains`: ROS domain ids and the range of discovery. `domain_lease`: a domain for exclusive use.
  `ports`: domains in use, by their UDP ports; `crowd`: more nodes than have ports.

Folder: `cleanup/` stops what outlives its process, or the launcher.
"""
