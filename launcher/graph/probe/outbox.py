"""Outbox: lines on their way out, with a limit on what a slow reader costs.

Answers and events are kept until they are read, messages only up to a limit: what does not fit is
counted, and the count told as soon as there is room.
"""

from __future__ import annotations

import json
import os
from collections import deque
from collections.abc import Mapping
from typing import Any

from launcher.graph.probe.clock import moment
from launcher.graph.to_yaml import to_json_plain

LIMIT_BYTES = 16 * 2**20  # of messages that wait
MESSAGE_BYTES = 2**20  # a longer one is told without its content
WRITE_BYTES = 2**16

Line = tuple[bytes, bool]  # and whether it is a message


class Outbox:
    """Writes to a descriptor that does not block. `say` may be called from any thread."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._lines: deque[Line] = deque()
        self._partial = b""
        self._waiting_bytes = 0
        self._dropped = 0
        self._graph: Mapping[str, Any] | None = None
        self.is_broken = False

    def say(self, document: Mapping[str, Any]) -> None:
        """A line that is never thrown away."""
        self._lines.append((encoded(document), False))

    def show(self, graph: Mapping[str, Any]) -> None:
        """The graph as it is now, in place of one that is still waiting."""
        self._graph = graph

    def hand_over(self, message: Mapping[str, Any]) -> None:
        """A line that is thrown away if the reader is too far behind."""
        line = encoded(message)
        if len(line) > MESSAGE_BYTES:
            line = encoded({**message, "data": None, "bytes": len(line)})
        if self._waiting_bytes + len(line) > LIMIT_BYTES:
            self._dropped += 1
            return
        self._tell_dropped()
        self._waiting_bytes += len(line)
        self._lines.append((line, True))

    def _tell_dropped(self) -> None:
        if self._dropped:
            self.say({"event": "dropped", "messages": self._dropped, **moment()})
            self._dropped = 0

    @property
    def is_empty(self) -> bool:
        """Whether everything has been written."""
        return not (self._lines or self._partial or self._graph or self._dropped)

    def flush(self) -> None:
        """Write as much as the reader takes now."""
        while not self.is_broken and (chunk := self._partial or self._next_chunk()):
            try:
                self._partial = chunk[os.write(self._descriptor, chunk) :]
            except BlockingIOError:
                self._partial = chunk
                return
            except OSError:
                self.is_broken = True

    def _next_chunk(self) -> bytes:
        if not self._lines:
            self._tell_dropped()
        if self._graph is not None:
            self.say(self._graph)
            self._graph = None
        lines: list[bytes] = []
        size = 0
        while self._lines and size < WRITE_BYTES:
            line, is_message = self._lines.popleft()
            self._waiting_bytes -= len(line) if is_message else 0
            size += len(line)
            lines.append(line)
        return b"".join(lines)


def encoded(document: Mapping[str, Any]) -> bytes:
    """One line of JSON; what JSON has no word for (nan, inf) becomes a string."""
    try:
        text = json.dumps(document, allow_nan=False, separators=(",", ":"))
    except ValueError:
        text = json.dumps(to_json_plain(dict(document)), separators=(",", ":"))
    return text.encode() + b"\n"
