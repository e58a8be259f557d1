"""Frames that are kept until the other side has acknowledged them."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

from launcher.hosts.engine.frames import HEADER, OUTPUT_HEADER, FrameKind, encode, pack

_OVERHEAD = 150  # bytes of memory for an entry besides its data
_TEXT_AT = HEADER.size + OUTPUT_HEADER.size  # where the bytes of an output frame begin
# Shorter bytes are copied behind their header: for the kernel, a second buffer costs more.
_LEAST_APART = 4096


class QueuedFrame:
    """A frame: `data`, then `rest`.

    `lines` is how many lines of output were dropped with it; None: it is no output.
    """

    __slots__ = ("data", "lines", "rest", "sequence")

    def __init__(self, sequence: int, data: bytes, lines: int | None, rest: bytes = b"") -> None:
        self.sequence = sequence
        self.data = data
        self.lines = lines
        self.rest = rest

    @property
    def size(self) -> int:
        return len(self.data) + len(self.rest) + _OVERHEAD

    def count_lines(self) -> int:
        """Of its output, or of what was dropped with it."""
        return self.lines or self.data.count(b"\n", _TEXT_AT) + self.rest.count(b"\n")


class _Shelf:
    """Entries in the order of their numbers; the oldest output can be dropped.

    Then `old` has what is left of the oldest part: entries that are no output, and markers.
    """

    def __init__(self) -> None:
        self.old: deque[QueuedFrame] = deque()
        self.new: deque[QueuedFrame] = deque()

    def __bool__(self) -> bool:
        return bool(self.old or self.new)

    def __iter__(self) -> Iterator[QueuedFrame]:
        yield from self.old
        yield from self.new

    def first(self) -> QueuedFrame:
        return self.old[0] if self.old else self.new[0]

    def pop(self) -> QueuedFrame:
        return self.old.popleft() if self.old else self.new.popleft()

    def drop(self, now: float) -> int | None:
        """Replace the oldest output by a marker; the bytes less. None: there is no output."""
        while self.new:
            entry = self.new.popleft()
            if entry.lines is None:
                self.old.append(entry)
                continue
            freed = entry.size
            last = self.old[-1] if self.old else None
            lines = entry.count_lines()  # a marker may be here, too, after `resume`
            if last is not None and last.lines is not None:
                lines += last.lines
                freed += self.old.pop().size
            payload = pack({"lines": lines})
            data = encode(FrameKind.DROPPED, entry.sequence, now, payload)
            marker = QueuedFrame(entry.sequence, data, lines)
            self.old.append(marker)
            return freed - marker.size
        return None


class Outbox:
    """Numbers frames and keeps them.

    `bytes` is the size of all that are kept, `sequence` the last number.
    """

    def __init__(self) -> None:
        self.sequence = 0
        self._sent = _Shelf()
        self._unsent = _Shelf()
        self.bytes = 0

    @property
    def is_empty(self) -> bool:
        return not (self._sent or self._unsent)

    @property
    def has_unsent(self) -> bool:
        return bool(self._unsent)

    def add(self, kind: int, time_s: float, payload: bytes, rest: bytes = b"") -> None:
        """Keep a frame, whose payload ends with `rest`."""
        if len(rest) < _LEAST_APART:
            payload, rest = payload + rest, b""
        self.sequence += 1
        lines = 0 if kind == FrameKind.OUTPUT else None
        data = encode(kind, self.sequence, time_s, payload, follow=len(rest))
        entry = QueuedFrame(self.sequence, data, lines, rest)
        self._unsent.new.append(entry)
        self.bytes += entry.size

    def take(self) -> tuple[bytes, ...]:
        """The next frame to send, in one or two parts."""
        entry = self._unsent.pop()
        self._sent.new.append(entry)
        return (entry.data, entry.rest) if entry.rest else (entry.data,)

    def acknowledge(self, sequence: int) -> int:
        """The other side has all frames up to this one; the bytes less."""
        before = self.bytes
        while self._sent and self._sent.first().sequence <= sequence:
            self.bytes -= self._sent.pop().size
        return before - self.bytes

    def resume(self, sequence: int) -> None:
        """On a new connection: all frames after this one are to be sent again."""
        unsent = _Shelf()
        for entry in (*self._sent, *self._unsent):
            if entry.sequence > sequence:
                unsent.new.append(entry)
            else:
                self.bytes -= entry.size
        self._sent, self._unsent = _Shelf(), unsent

    def limit(self, most: int, now: float) -> None:
        """Drop the oldest output until at most so many bytes are kept."""
        while self.bytes > most:
            freed = self._sent.drop(now)
            if freed is None:
                freed = self._unsent.drop(now)
            if freed is None:
                return
            self.bytes -= freed
