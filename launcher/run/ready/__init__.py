"""When processes are ready, and starts that wait for it.

`start_order` decides (pure): which first starts wait for which processes, each a
`waiting_process`. `gate` holds them back, between the machine of a process and its spawn.
`ready_watch` looks for the facts of `ready_when`, in the output, by `attempts` (a TCP connection, a
command) or the graph (`launcher.run.helpers.graph_facts`). What a supervision file may say is read
in `launcher.launch.supervise`.
"""
