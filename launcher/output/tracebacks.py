"""Keeps the lines of tracebacks together on the screen, and shortens those of an ordinary stop.

Python writes a traceback line by line, so lines of other nodes could come in between. A node that
does not catch KeyboardInterrupt or rclpy's ExternalShutdownException prints twenty useless lines
when it is stopped: they are shortened to one. rcl's warning about messages that are logged after
the shutdown of its context is hidden.
"""

from __future__ import annotations

import re

_BEGIN = b"Traceback (most recent call last):"
_PARENTHESIS = _BEGIN[10]
_COLOUR = rb"\x1b\[[0-9;:]*m"
_OF_A_STOP = rb"(?:\w+\.)*(KeyboardInterrupt|ExternalShutdownException)\b"
_TO_ROSOUT = b"Failed to publish log message to rosout: publisher's context is invalid"
HELD_LIMIT = 64 * 1024  # bytes; longer text is not a traceback


class TracebackGate:
    """One per stream that is shown. `feed` and `flush` return what may be shown."""

    def __init__(self) -> None:
        self._held = b""

    @property
    def holds(self) -> bool:
        return bool(self._held)

    def feed(self, lines: bytes, *, stopping: bool) -> bytes:
        """Whole lines in, whole lines out. `stopping`: the process is being stopped."""
        if stopping and _TO_ROSOUT in lines:
            lines = re.sub(rb"(?m)^(?:%s)*%s.*\n" % (_COLOUR, _TO_ROSOUT), b"", lines)
        if not self._held and not has_begin(lines):
            return lines
        block, self._held = self._held + lines, b""
        passed: list[bytes] = []
        while block:
            before, block = _split_before_begin(block)
            passed.append(before)
            end = _end_of_traceback(block)
            if end is None:
                self._held = block
                break
            passed.append(_folded(block[:end]) if stopping else block[:end])
            block = block[end:]
        if len(self._held) > HELD_LIMIT:
            passed.append(self.flush())
        return b"".join(passed)

    def flush(self) -> bytes:
        """Return what was held, complete or not."""
        held, self._held = self._held, b""
        return held


def has_begin(text: bytes) -> bool:
    """Whether the first line of a traceback is in it."""
    # This runs for every read: search one byte first; `rfind` is up to five times as fast as `in`.
    return _PARENTHESIS in text and text.rfind(_BEGIN) >= 0


def _split_before_begin(block: bytes) -> tuple[bytes, bytes]:
    found = block.find(_BEGIN)
    if found < 0:
        return block, b""
    start = block.rfind(b"\n", 0, found) + 1
    return block[:start], block[start:]


def _end_of_traceback(block: bytes) -> int | None:
    """The end of the line with the exception, after the frames; None if it has not come yet."""
    position = block.find(b"\n") + 1
    while 0 < position < len(block):
        end = block.index(b"\n", position) + 1
        line = re.sub(_COLOUR, b"", block[position:end])
        if line.strip() and not line.startswith((b" ", b"\t")):
            return end
        position = end
    return None


def _folded(traceback: bytes) -> bytes:
    last = re.sub(_COLOUR, b"", traceback).rstrip(b"\n").rpartition(b"\n")[2]
    found = re.match(_OF_A_STOP, last)
    if found is None:
        return traceback
    return b"(ended by %s, which the program does not catch; traceback in its log)\n" % found[1]
