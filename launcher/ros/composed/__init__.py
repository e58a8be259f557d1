"""Several node programs in one process: `python -m launcher.ros.composed`.

Each program runs in a separate thread, as if it were alone: with its own `sys.argv`, signal
handlers and exit code. Their nodes share one participant of DDS, and so one rcl context; what each
program takes for the context is a `MemberContext`. What it makes of executors stays its own: no
callback of one node waits for those of another.

The main thread has the signals and the requests of the launcher. Functions of rclpy, `sys.argv`,
`signal.signal` and the standard streams are replaced by ones that look which member the thread
belongs to (`current`), and nothing else is.

The standard input is a socket, which it moves to a separate descriptor at once (`control`):
requests come in by it, and messages such as `INDEX exit 0` go out. A message is passed on behind
all output that was written before it. What Python writes goes to the streams of the process, in the
order of writing with what C writes, in frames that name the member
(`launcher.run.compose.group_output`); a frame is no longer than what the kernel writes to a pipe at
once.
"""
