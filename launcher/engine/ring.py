"""LogRing: the last of what one process wrote, kept as it came and split only when asked for."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator

LIMIT_BYTES = 256 * 1024
LIMIT_BLOCKS = 1000  # a process that writes line by line makes a block of each


class Block:
    """Whole lines of one stream (`stdout`, `stderr`, `both`), and when they were read.

    `heard_s` is on the monotonic clock. Not a Record: one is made for every read.
    """

    __slots__ = ("heard_s", "lines", "stream")

    def __init__(self, stream: str, heard_s: float, lines: bytes) -> None:
        self.stream = stream
        self.heard_s = heard_s
        self.lines = lines


class LogRing:
    """Bounded memory of whole lines. `tap`, if set, gets each block as it comes."""

    __slots__ = ("_blocks", "_bytes", "tap")

    def __init__(self) -> None:
        self._blocks: deque[Block] = deque()
        self._bytes = 0
        self.tap: Callable[[Block], None] | None = None

    def append(self, stream: str, heard_s: float, lines: bytes) -> None:
        """Remember a block, and forget the oldest beyond the limits."""
        block = Block(stream, heard_s, lines)
        blocks = self._blocks
        blocks.append(block)
        self._bytes += len(lines)
        while self._bytes > LIMIT_BYTES or len(blocks) > LIMIT_BLOCKS:
            self._bytes -= len(blocks.popleft().lines)
        if self.tap is not None:
            self.tap(block)

    def last(self, most: int) -> list[Block]:
        """The newest blocks, in order, that together hold the last `most` lines; cut to them."""
        found: list[Block] = []
        missing = most
        for block in reversed(self._blocks):
            if missing <= 0:
                break
            lines = block.lines[:-1].split(b"\n")[-missing:]
            missing -= len(lines)
            found.append(Block(block.stream, block.heard_s, b"\n".join(lines) + b"\n"))
        return found[::-1]

    def texts(self, most: int) -> list[str]:
        """The last `most` lines as text, without their newlines."""
        return [text for block in self.last(most) for text in texts_of(block)]


def texts_of(block: Block) -> Iterator[str]:
    """The lines of a block as text, without their newlines."""
    for line in block.lines[:-1].split(b"\n"):
        yield line.decode(errors="replace").rstrip("\r")
