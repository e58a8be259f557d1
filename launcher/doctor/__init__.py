"""`doctor`: finds what makes ROS runs fail on this machine, and repairs what can be repaired.

May import the core, `hosts`, `ros` and `workspace`. `verb` is its door; the wing
`workspace` uses its facts about a workspace.

Gathering, judging and repairing are apart: only the first does I/O, so that each check is a
function from facts to one finding.

* Gather: `collect` has the machine, `network_facts` discovery (settings, multicast, clock, running
  nodes), `settings` the variables of ROS and of the middleware with the files that they name,
  `stale_workspace` what is stale in a workspace. The result is `doctor_facts`.
* Judge: `checks`, `network_checks`, `settings_checks`, `workspace_checks`; the latter are left out
  where there is no workspace. docs/reference/doctor.md lists all checks.
* Repair: `repairs`, for `--fix`; each returns messages about what it did.
"""
