"""The end of a run, and what processes leave behind.

`shutdown_machine` decides the steps: inform the launch file, stop the processes in reverse order of
start, escalate, stop leftovers, compute the exit code. `shutdown` carries them out.

`leftovers` stops all processes with the run's id in their environment, and all that the launcher
has adopted with their descendants, at the end. `session_end` stops at once what a process that was
stopped, or is restarted, leaves in its session; children of a process that exited by itself may be
intended, and run until the end.
"""
