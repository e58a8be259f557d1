"""Launching: from a launch file on a command line to a run, a plan or a report.

May import the rooms before it, down to `control`.

Doors:

* `verbs/`: `launch`, `run`, `plan` and `args`. `launch_service_run`: a LaunchService in a script,
  run by the engine. `outline`, `run_forecast`: what other processes ask for by `python -m` or at
  start.
* `target`: the launch file that a command line names, and its arguments; `declared_arguments`:
  those that a launch file declares. `launch_options` and `process_options`: the tables of options
  of a run, and what is made of them.
* `launch_core`: the interpreter as the engine sees it; a supervisor.
* `launch_checks`, `mistakes`, `known_names`, `program_warnings`, `participant_limits`: what is
  judged between the evaluation of a launch file and its first process, on the effects of the one
  evaluation that then runs. A run makes no plan. `time_limit` interrupts an evaluation that takes
  too long.
* `composing`: which nodes `--compose` puts into one process. `files_read`: files that the
  evaluation reads, for `--watch`. `reloading`: a fresh evaluation, which takes the place of the
  first one. `run_plan`: a plan of what a run has done.

Folders: `plan/` has the driver in virtual time (`planner`) and plans as text and JSON;
`supervise/` reads supervision files; `analyze/` shows where
the time of a start-up went.
"""
