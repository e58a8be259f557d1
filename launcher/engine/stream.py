"""Stream: one of the descriptors that the output of a process is read from."""

from __future__ import annotations

from launcher.engine.lines import LineBuffer
from launcher.engine.tracebacks import TracebackGate


class Stream:
    """One descriptor that output is read from: `name` is `stdout`, `stderr` or `both`."""

    __slots__ = ("buffer", "gate", "heard_s", "name", "shown")

    def __init__(self, name: str, *, shown: bool) -> None:
        self.name = name
        self.shown = shown
        self.heard_s = 0.0  # when it last wrote, on the monotonic clock
        self.buffer = LineBuffer()
        self.gate = TracebackGate()

    @property
    def waits(self) -> bool:
        """Whether something that is to be shown waits for its end."""
        return self.shown and (bool(self.buffer.partial) or self.gate.holds)
