"""Plans and arguments of launch files as text and JSON.

`planner` drives the interpreter in virtual time: it executes no process. `plan` is what it found,
which `plan_tree` (made of `branches`) and `plan_json` show, with `entities` and `start_rules`;
`plan_places` has the hosts; `plan_certainty` says how sure an entry and the name of a process is,
`shell_command` how it is shown; `tree` draws trees.
"""
