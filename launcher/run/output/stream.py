"""One stream of a process that output is read from."""

from __future__ import annotations

from launcher.output.lines import LineBuffer
from launcher.output.tracebacks import TracebackGate


class Stream:
    """One descriptor that output is read from: `name` is `stdout`, `stderr` or `both`.

    `ago_s` is how long ago another host had read the last block when it arrived here.
    """

    __slots__ = ("ago_s", "buffer", "gate", "name", "read_at_s", "shown")

    def __init__(self, name: str, *, shown: bool) -> None:
        self.name = name
        self.shown = shown
        self.read_at_s = 0.0  # when it last wrote, on the monotonic clock
        self.ago_s = 0.0
        self.buffer = LineBuffer()
        self.gate = TracebackGate()

    @property
    def waits(self) -> bool:
        """Whether an unfinished line or traceback is still to be shown."""
        return self.shown and (bool(self.buffer.partial) or self.gate.holds)
