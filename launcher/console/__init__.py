"""The console: prompt and status bar below the output of a run, in a process of its own.

The supervisor starts it if there is a terminal. It reads the output of the run from a pipe, and is
an ordinary client of the control socket for everything else.
"""
