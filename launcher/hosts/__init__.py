"""Processes of a launch file on other hosts: which hosts there are, and what runs where.

May import the core, `ros` and `workspace`. A run without a hosts file imports nothing of it.

Doors:

* `file/`: reads a hosts file, places processes, and makes the orders for hosts.
* `engine/`: the operator's side of the engines. `engine.fleet` opens the links of a run, says what
  became of them, and waits for the hosts at the end; `engine.driver` is the process driver of a
  run with hosts.
* `launching/`: the options of a launch with hosts: which hosts it needs, and its plan.
* `agent/`: `launcher agent`, the engine on a host without systemd.
* `check/` and `sync/`: `hosts check` and `hosts sync`. `verbs/`: these, `attach` and `agent`.
* `discovery`: the variables with which nodes on several hosts find each other; `discovery_server`:
  a separate program that becomes Fast DDS's.
* `ssh`: command lines of OpenSSH; `failures`: what its messages mean; `ssh_command`: one command on
  a host. `unit`: the settings of systemd units, for runs and for export. `identity`: what launchers
  on two hosts compare.

A host decides about its processes: it has the state machine of each and carries out its actions,
also while the operator cannot be reached. A link carries commands there, and back every event that
a machine has handled, with its time. The launcher feeds these to a replica of the machine, and
carries out only its reporting actions: log lines, history, events for the interpreter.
"""
