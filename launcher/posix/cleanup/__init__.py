"""Stops what outlives its process or the launcher: leftovers, the watchdog.

* `subreaper` makes the launcher the parent of orphans. `sweep` finds processes by the run's id in
  their environment (`run_id`), and signals them.
* `watchdog_client` starts the watchdog before the first process, which does not wait for it.
  `watchdog` is a script without site-packages that waits on a pipe; `run_watch` holds its
  data of the run, and kills the run if the launcher dies.
* `cgroup`: a control group of the run, where one can be made, leaves the watchdog nothing to
  search. The watchdog moves the launcher into it, and what was started in the meantime; that takes
  the kernel 10 ms, which nobody waits for. `cgroup.kill` empties it; with version 1 all its
  processes are signalled until it is empty. At the end the launcher leaves it while they stop.

Where there is no control group, the watchdog notes the children that the launcher has adopted ten
times a second, and all descendants once a second if anything was started on the machine. Before it
kills, it suspends the run and looks for descendants of what it has found.

A process that was a child of the launcher before the run (of a shell that became the launcher by
`exec`) is not of the run. What such a process leaves could not be distinguished from what the run
leaves: then the launcher adopts nothing.
"""

RUN_ID_VARIABLE = "LAUNCHER_RUN_ID"  # in the environment of everything that a run starts
