"""Standard output and error: what Python writes, in frames that name the member.

A frame is `RS TOKEN INDEX US TEXT LF`, for a line or its end, or has GS in place of US if the line
goes on. The token is random, so that no output of a program is taken for a frame. What C writes,
such as lines of rcl, comes as it is; it may be in pieces, and then there may be frames in between.
"""

from __future__ import annotations

import io
import os
import select
import sys
import threading
from collections.abc import Iterator
from typing import Any

from launcher.ros.composed import control, current

RS, GS, US = b"\x1e", b"\x1d", b"\x1f"
FRAME_BYTES = select.PIPE_BUF  # of which the kernel puts nothing else in between
_TOKEN = os.urandom(8).hex().encode()
_lock = threading.Lock()


class MemberStream(io.TextIOBase):
    """Stands for a standard stream; what no member writes passes unchanged."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream
        self._partial: dict[int, str] = {}

    def write(self, text: str) -> int:
        one = current.member()
        if one is None:
            return int(self._stream.write(text))
        with _lock:
            *lines, rest = (self._partial.get(one.index, "") + text).split("\n")
            is_long = len(rest) >= FRAME_BYTES
            self._partial[one.index] = "" if is_long else rest
            self._put(one.index, lines, rest if is_long else "")
        return len(text)

    def finish(self, index: int) -> None:
        """Write what the member has written after its last line."""
        with _lock:
            rest = self._partial.pop(index, "")
            self._put(index, [rest] if rest else [])

    def _put(self, index: int, lines: list[str], begun: str = "") -> None:
        if not lines and not begun:
            return
        self._stream.flush()
        encoding, errors = self._stream.encoding, self._stream.errors
        frames = [one for line in lines for one in _frames(index, line.encode(encoding, errors))]
        if begun:
            frames += _frames(index, begun.encode(encoding, errors), end=GS)
        for block in _blocks(frames):
            write_all(self._stream.fileno(), block)

    def flush(self) -> None:
        if current.member() is None:
            self._stream.flush()

    def writable(self) -> bool:
        return True

    def __getattribute__(self, name: str) -> Any:
        if name in ("buffer", "encoding", "errors", "fileno", "isatty", "mode", "name"):
            return getattr(object.__getattribute__(self, "_stream"), name)
        return object.__getattribute__(self, name)


def _frames(index: int, line: bytes, *, end: bytes = US) -> Iterator[bytes]:
    """Those of a line, each small enough."""
    head = b"%b%b%d" % (RS, _TOKEN, index)
    room = FRAME_BYTES - len(head) - 2
    while len(line) > room:
        yield head + GS + line[:room] + b"\n"
        line = line[room:]
    yield head + end + line + b"\n"


def _blocks(frames: list[bytes]) -> Iterator[bytes]:
    """The frames, as many as possible in each write."""
    block = b""
    for frame in frames:
        if len(block) + len(frame) > FRAME_BYTES:
            yield block
            block = b""
        block += frame
    yield block


def write_all(fd: int, data: bytes) -> None:
    """Nothing is lost but what nobody reads."""
    try:
        while data:
            try:
                data = data[os.write(fd, data) :]
            except BlockingIOError:  # a child of a node has set the pipe to that
                select.select([], [fd], [])
    except OSError:
        return


def install() -> tuple[MemberStream, MemberStream]:
    """Before any program is started."""
    control.send("token", _TOKEN.decode())
    streams = MemberStream(sys.stdout), MemberStream(sys.stderr)
    sys.stdout, sys.stderr = streams
    return streams
