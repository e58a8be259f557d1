"""The console: a prompt and a status bar below the output of a run, in a process of its own.

Started by the supervisor (`engine.console_link`) where there is a terminal. It gets the run's
output through a pipe and is an ordinary client of the control socket for everything else.
"""
