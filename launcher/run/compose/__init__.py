"""Several nodes of a launch file in one process, for `--compose`.

`composed_core` stands in front of the core of the run: effects about one of the nodes become
effects about the process, and events of the process become events of its nodes. `group_output`
splits the output by member: by frames that name the member, also within a line; it is used by
`composed_members`, which reports their ends. `launcher.launch.composing` says which nodes
are put together; `launcher.ros.composed` is the process.
"""
