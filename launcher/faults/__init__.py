"""A run that is watched: expectations that hold while it lives, faults, causes and incidents.

May import the core, `bag`, `ros`, `smoke` and `web`. Never imports rclpy: the probe observes ROS.

A watched run is a smoke run whose window slides: what `launcher.smoke` judges once, at the end, is
judged here several times a second, on the last seconds. What needs an end is left to smoke.

Doors: `fault_watch`, the part of a run (`--expect`, `--watchful`) and its verb `faults`;
`verb`, the same from another shell; `watch_options`, the values of its options.

Folders, in the order of what happens:

* `watcher/`: a helper process of the run, client of its control socket and of the probe. It
  collects observations, has them judged, and reports each change of a fault.
* `checks/`: for each kind of expectation whether it holds now, mostly by the judges of smoke.
* `model/`: a fault and its life (suspected, active, healed), without I/O.
* `causes/`: rules that say why, and which faults follow from another: an incident.
* `actions/`: what a supervision file says is done for a fault.
* `history/`: the faults of all runs, in a database in the log folder.
* `incident/`: one HTML file about one incident, and its verb.
"""
