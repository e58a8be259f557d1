"""The console: prompt and status bar below the output of a run, in a separate process.

The supervisor starts it on a terminal. It reads the output of the run from a pipe; otherwise it is
a client of the control socket.
"""
