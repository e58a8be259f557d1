"""Several node programs in one process: `python -m launcher.ros.composed`.

Each program runs in a thread of its own, as if it were alone: with its own `sys.argv`, signal
handlers and exit code. Their nodes share one participant of DDS, and so one rcl context; what each
program takes for the context is a `MemberContext`. What it makes of executors stays its own: no
callback of one node waits for those of another.

The output is for the launcher, see `launcher.run.compose.output`.
"""
