"""Plans and arguments of launch files as text and JSON.

`planner` drives the interpreter in virtual time: it executes no process. `plan_tree` and
`plan_json` show what it found, with `entities`, `hosts` and `start_rules`; `plan_certainty` says
how sure an entry and the name of a process is, `shell_command` how it is shown; `tree` draws trees.
"""
