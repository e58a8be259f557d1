"""Stops what outlives its process or the launcher: leftovers, the watchdog.

* `subreaper` makes the launcher the parent of orphans. `sweep` finds processes by the run's id in
  their environment (`run_id`), and signals them.
* `watchdog_client` starts the watchdog before the first process, which does not wait for it.
  `watchdog` is a script without site-packages that waits on a pipe; `watch` is what it knows of
  the run, and how it kills that if the launcher dies.
* `cgroup`: a control group of the run, where one can be made, leaves the watchdog nothing to
  search.
"""

RUN_ID_VARIABLE = "LAUNCHER_RUN_ID"  # in the environment of everything that a run starts
