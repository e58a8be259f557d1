"""The control socket of a run: server, protocol and client (docs/reference/control.md).

May import the rooms before it: `base`, `posix`, `packages`, `output`, `language` and `run`.

On the side of the run, in the thread of the supervisor: `control_server` accepts connections of its
owner and root, `peer` is one of them (reads requests, queues answers until the client reads),
`control_service` checks a request and has it carried out. Clients are served one request per pass
of the loop, and all queues are bounded.

Doors:

* `verbs`: one table of verbs and options, for requests of programs, command lines, completion and
  the console. `verb` is what a shell runs: `ps`, `stop`, `logs` and so on.
* `protocol`: one JSON object per line. `client`: blocking calls with timeouts. `active_runs`: the
  active runs of this user, found by id, pid or target.
* `answer_lines` makes lines of answers and items; `status` has the rows of `ps`, `log_followers`
  the lines of processes.

`control_server` and `console_process` have the parts of a run that open these. Verbs of other parts
come from `launcher.run.part_verbs`.

Folder: `console/` is the prompt and the status bar, a separate process.
"""
