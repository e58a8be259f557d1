"""The console: prompt and status bar below the output of a run, in a separate process.

The supervisor starts it on a terminal. It reads the output of the run from a pipe; otherwise it is
a client of the control socket.

`console_session` composes it: `feed` reads, `display` and `bar` draw, `prompt` edits a line, with
its history and `completion`; `requests` sends what was typed. `panel` is the picker, with its list
(`picker`) and texts (`pager`). `top` serves other shells, too. `shell_verbs` runs verbs of the
command line as processes, each with a `guard` that ends it with the console.
"""
