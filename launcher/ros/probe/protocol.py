"""The probe's lines of JSON: requests that come in, answers and events that go out.

Times are on two clocks: DDS stamps messages in wall time; the monotonic clock is the same for all
processes of a machine.
"""

from __future__ import annotations

import os
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

from launcher.base import strict_json
from launcher.base.ros_errors import VerbError

NANOS = 1_000_000_000
READ_BYTES = 2**16
LIMIT_BYTES = 16 * 2**20  # of messages that wait for a slow reader; more are dropped
MESSAGE_BYTES = 2**20  # a longer message goes out without its content
WRITE_BYTES = 2**16

Line = tuple[bytes, bool]  # and whether it is a message


def moment() -> dict[str, float]:
    return {"mono": time.monotonic(), "wall": time.time()}


def wall_offset_ns() -> int:
    return time.time_ns() - time.monotonic_ns()


class Inbox:
    """Reads lines from a descriptor; `is_closed` at its end."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._partial = b""
        self.is_closed = False

    def lines(self) -> list[bytes]:
        """Complete lines; call it when the descriptor is readable."""
        chunk = os.read(self._descriptor, READ_BYTES)
        self.is_closed = not chunk
        *lines, self._partial = (self._partial + chunk).split(b"\n")
        return [line for line in lines if line.strip()]


class Waker:
    """Ends a `select` on `descriptor`, from any thread and from handlers of signals."""

    def __init__(self) -> None:
        self.descriptor = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)

    def wake(self) -> None:
        os.eventfd_write(self.descriptor, 1)

    def reset(self) -> None:
        """Call it when the descriptor is readable."""
        os.eventfd_read(self.descriptor)


class ProbeRequest:
    """One request. The methods return fields by name and kind; VerbError if one does not fit."""

    def __init__(self, line: bytes) -> None:
        self.id: object = None
        self.cancelled = threading.Event()  # may be set from any thread
        try:
            fields = strict_json.loads(line)
        except ValueError as error:
            raise VerbError(f"not a line of JSON: {error}") from None
        if not isinstance(fields, dict):
            raise VerbError("a request is a JSON object")
        self.id = fields.get("id")
        self._fields = fields

    @property
    def word(self) -> str:
        return str(self._fields.get("do"))

    @property
    def of(self) -> Any:
        """The id of another request."""
        return self._fields.get("of")

    def _optional(self, name: str, noun: str, fits: Callable[[Any], object]) -> Any:
        """A field, None if it is missing or null."""
        value = self._fields.get(name)
        if value is not None and not fits(value):
            raise VerbError(f"'{name}' must be {noun}, got {strict_json.dumps(value)}")
        return value

    def text(self, name: str) -> str:
        """A text that is required and not empty."""
        value = self.optional_text(name)
        if value is None:
            raise VerbError(f"'{name}' must be a text, got null")
        return value

    def optional_text(self, name: str) -> str | None:
        value: str | None = self._optional(name, "a text", lambda v: isinstance(v, str) and v)
        return value

    def number(self, name: str, default: float) -> float:
        """A number that is not negative."""
        value = self.optional_number(name)
        return default if value is None else value

    def optional_number(self, name: str) -> float | None:
        value = self._optional(name, "a number", _is_number)
        return None if value is None else float(value)

    def flag(self, name: str, default: bool) -> bool:
        value = self._fields.get(name, default)
        if not isinstance(value, bool):
            raise VerbError(f"'{name}' must be true or false, got {strict_json.dumps(value)}")
        return value

    def mapping(self, name: str) -> dict[str, Any] | None:
        value: dict[str, Any] | None
        value = self._optional(name, "an object", lambda v: isinstance(v, dict))
        return value

    def names(self, name: str) -> list[str] | None:
        value: list[str] | None = self._optional(name, "a list of texts", _are_texts)
        return value

    def values(self) -> dict[str, Any]:
        """`values`: the fields of a message, as an object or as YAML."""
        from launcher.ros.messages.from_yaml import parse

        if isinstance(self._fields.get("values"), str):
            return parse(self._fields["values"])
        return self.mapping("values") or {}


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and value >= 0


def _are_texts(value: object) -> bool:
    return isinstance(value, list) and all(isinstance(item, str) for item in value)


class LineOutbox:
    """Queues lines for a descriptor that does not block. `send` may be called from any thread.

    Answers and events are kept until they are read; messages only up to LIMIT_BYTES. Dropped ones
    are counted, and the count is reported as soon as there is room.
    """

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._lines: deque[Line] = deque()
        self._partial = b""
        self._waiting_bytes = 0
        self._dropped = 0
        self._graph: Mapping[str, Any] | None = None
        self.is_broken = False

    def send(self, document: Mapping[str, Any]) -> None:
        """Queue a line that is never dropped."""
        self._lines.append((encoded(document), False))

    def show(self, graph: Mapping[str, Any]) -> None:
        """Queue the graph, in place of one that is still waiting."""
        self._graph = graph

    def push(self, message: Mapping[str, Any]) -> None:
        """Queue a line, or drop it if the reader is too far behind."""
        line = encoded(message)
        if len(line) > MESSAGE_BYTES:
            line = encoded({**message, "data": None, "bytes": len(line)})
        if self._waiting_bytes + len(line) > LIMIT_BYTES:
            self._dropped += 1
            return
        self._report_dropped()
        self._waiting_bytes += len(line)
        self._lines.append((line, True))

    def _report_dropped(self) -> None:
        if self._dropped:
            self.send({"event": "dropped", "messages": self._dropped, **moment()})
            self._dropped = 0

    @property
    def is_empty(self) -> bool:
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
            self._report_dropped()
        if self._graph is not None:
            self.send(self._graph)
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
    """One line of JSON; nan and inf become strings."""
    text = strict_json.dumps(document, not_finite=str, separators=(",", ":"))
    return text.encode() + b"\n"
