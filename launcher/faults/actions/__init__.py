"""What is done for faults: `on:` of a supervision file.

`fault_actions` is the part of the run; `outside_program` runs commands, `webhook` (a program) and
`desktop` for it, so that nothing in the loop of the run waits; `action_budget` bounds how often.
The grammar is in `launcher.launch.supervise.fault_fields`.
"""
