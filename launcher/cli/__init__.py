"""The command line: its first word is a verb, or else a launch target.

May import all of the core, and no wing: `launcher.base.verb_table` names the module of a verb,
which `dispatch` imports. It is on the way to the first process of every launch, and avoids every
import that it can (tests/launch/process/test_startup.py).

Doors:

* `dispatch.main(words)`: enters the workspace, finds the verb, runs it, and prints errors with
  their exit codes. `launcher.__main__` is before it: standard files, Ctrl-C, closed pipes.
* `overview`: what the program prints without words, and with `--help`.
* `workspace_option`: `--workspace DIR`, in front of a verb or behind it.
* `lookup`: the table of options that a command line is parsed with, for those that look at a
  command line without running it.
* `absent_verbs`, `absent_modules`: errors for words that are no verbs here, such as those of
  ros2cli, and for Python packages that are not installed.

Folder: `completion/` is the verb `completion`, with the scripts for shells and what Tab asks for:
`candidates` finds the place in the tables of options, `name_sources` has the names there.
"""
