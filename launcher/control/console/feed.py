"""Reads the output of the launcher from a pipe and splits it into whole lines."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable

# Bytes per read: what the terminal writes in about 0.1 s, since the echo of a key waits for it.
MIN_BYTES, INITIAL_BYTES, MAX_BYTES = 8 * 1024, 64 * 1024, 512 * 1024
SLOW_S = 0.1
# The footer is drawn again after each block: at most 60 times a second, unless blocks are large.
FRAME_S = 1 / 60
HURRY_BYTES = 16 * 1024

# A block may end anywhere: an unfinished line is shown only if nothing follows for so long.
PARTIAL_S = 0.05

OVERWRITE = b"\r\x1b[K"  # of progress bars, which rewrite their line


class Feed:
    """Calls `show(lines, partial)` with whole lines and the unfinished one, `on_end()` at EOF."""

    def __init__(
        self,
        loop: asyncio.AbstractEventLoop,
        fd: int,
        show: Callable[[bytes, bytes], None],
        on_end: Callable[[], None],
    ) -> None:
        self._loop = loop
        self._fd = fd
        self._show = show
        self._on_end = on_end
        self._partial = self._shown_partial = b""
        self._waiting: asyncio.TimerHandle | None = None
        self._slow = False
        self._slow_since_s = 0.0
        self._max_bytes = INITIAL_BYTES
        self._pausing = False
        self._ended = False
        os.set_blocking(fd, False)
        self._listen()

    def hold_back(self, slow: bool) -> None:
        """Do not read while the terminal is slow, so that the launcher waits for the pipe."""
        self._slow = slow
        if slow:
            self._slow_since_s = self._loop.time()
        elif self._loop.time() - self._slow_since_s > SLOW_S:
            self._max_bytes = max(MIN_BYTES, self._max_bytes // 2)
        self._listen()

    def catch_up(self) -> None:
        """Show what is in the pipe now, without waiting for the next frame."""
        if not self._slow and not self._ended:
            self._readable()

    def finish(self) -> None:
        """Show the rest of the pipe and end; the launcher has exited, but the pipe may be open."""
        while not self._ended:
            block, self._ended = self._read()
            self._ended = self._ended or not block
            self._take(block)
        self._listen()
        self._on_end()

    def _listen(self) -> None:
        if self._slow or self._pausing or self._ended:
            self._loop.remove_reader(self._fd)
        else:
            self._loop.add_reader(self._fd, self._readable)

    def _readable(self) -> None:
        block, self._ended = self._read()
        was_full = len(block) >= self._max_bytes
        self._take(block)
        if was_full and not self._slow:
            self._max_bytes = min(MAX_BYTES, 2 * self._max_bytes)
        if self._ended:
            self._listen()
            self._on_end()
        elif len(block) < HURRY_BYTES:
            self._pausing = True
            self._listen()
            self._loop.call_later(FRAME_S, self._resume)

    def _resume(self) -> None:
        self._pausing = False
        self._listen()

    def _read(self) -> tuple[bytes, bool]:
        """(contents of the pipe, whether it has ended)."""
        parts: list[bytes] = []
        size = 0
        while size < self._max_bytes:
            try:
                part = os.read(self._fd, self._max_bytes - size)
            except BlockingIOError:
                break
            if not part:
                return b"".join(parts), True
            parts.append(part)
            size += len(part)
        return b"".join(parts), False

    def _take(self, block: bytes) -> None:
        lines, self._partial = split(self._partial + block)
        if self._ended and self._partial:
            lines, self._partial = lines + self._partial + b"\n", b""
        if self._waiting is not None:
            self._waiting.cancel()
        if self._partial != self._shown_partial:
            self._shown_partial = b""
        if lines:
            self._show(lines, self._shown_partial)
        if self._partial and not self._shown_partial:
            self._waiting = self._loop.call_later(PARTIAL_S, self._show_partial)

    def _show_partial(self) -> None:
        self._shown_partial = self._partial
        self._show(b"", self._partial)


def split(data: bytes) -> tuple[bytes, bytes]:
    """(whole lines, unfinished line), without the parts that were overwritten."""
    head, newline, partial = data.rpartition(b"\n")
    lines = head + newline
    if OVERWRITE in lines:
        lines = b"\n".join(line.rpartition(OVERWRITE)[2] for line in lines.split(b"\n"))
    return lines, partial.rpartition(OVERWRITE)[2]
