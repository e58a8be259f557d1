"""Plain data that the interpreter and its drivers exchange: specs, effects, events.

* `record`: the base of immutable records, in place of dataclasses, which take long to import.
* `spec`: a process before it starts; `spec_diff` and `reload_changes`: what a new evaluation of the
  launch file changes; `run_options`: settings of a run and of its processes; `supervision`: those
  of supervision files; `level`: of findings.
* `events`: effects of the interpreter, and events that a driver reports.
* `run_events`: a type, with the base `run_event`, for each kind of entry of the event log: its
  fields, its words, and the text of docs/reference/events.md. `event_entries` reads and shows
  entries.
* `lifecycle_transitions`, `ros_arguments`, `ros_names`: words of ROS. `parameter_sections` and
  `parameter_text`: what rcl reads in parameter files.
"""
