"""Splits output into whole lines, and removes control characters before lines are shown."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Iterator

LINE_LIMIT = 64 * 1024  # bytes; a longer line is cut here
CUT_MARK = b" [... cut by the launcher]"

_RESET = b"\x1b[0m"

_SHIFTS = b"\x08\x0b\x0c\x0e\x0f"  # backspace, vertical tab, form feed, character sets


class LineBuffer:
    """Splits one stream of one process into lines; keeps an unfinished line.

    `shown` counts the bytes of the unfinished line that are already on the screen, as of a prompt.
    """

    mark = b""  # in front of lines of which more is known

    def __init__(self) -> None:
        self.partial = b""
        self.shown = 0
        self._overlong = False

    def feed(self, chunk: bytes) -> tuple[bytes, int]:
        """(whole lines that `chunk` completes, bytes of the first that are shown already)."""
        end = chunk.rfind(b"\n") + 1
        if not end:
            self._hold(chunk)
            return b"", 0
        begin = chunk.index(b"\n") if self._overlong else 0
        lines, shown = b"".join((self.partial, memoryview(chunk)[begin:end])), self.shown
        self._forget()
        if end < len(chunk):
            self._hold(chunk[end:])
        if _has_overlong(lines):
            lines = b"".join(_cut(line + b"\n") for line in lines[:-1].split(b"\n"))
        return lines, shown

    def take_partial(self) -> tuple[bytes, int]:
        """The unfinished line with a newline, as `feed` returns it; b'' if there is none."""
        lines, shown = self.partial, self.shown
        self._forget()
        return (lines + b"\n" if lines else b""), shown

    def _forget(self) -> None:
        self.partial = b""
        self.shown = 0
        self._overlong = False

    def _hold(self, data: bytes) -> None:
        if self._overlong:
            return
        self.partial += data
        if len(self.partial) > LINE_LIMIT:
            # Memory stays bounded: keep the beginning, drop the rest up to the next newline.
            self.partial = self.partial[:LINE_LIMIT] + CUT_MARK
            self._overlong = True


_LONGEST = LINE_LIMIT + len(CUT_MARK) + 1  # `_hold` may have cut it before


def _has_overlong(lines: bytes) -> bool:
    """Whether one of them is longer than `_LONGEST`, in a step for each block of that size.

    Most reads of a flood, with the line that was unfinished before, are longer than LINE_LIMIT.
    """
    begin = 0
    while len(lines) - begin > _LONGEST:
        begin = lines.rfind(b"\n", begin, begin + _LONGEST) + 1
        if not begin:
            return True
    return False


def _cut(line: bytes) -> bytes:
    return line if len(line) <= _LONGEST else line[:LINE_LIMIT] + CUT_MARK + b"\n"


def for_pipe(lines: bytes) -> bytes:
    """Whole lines without escape sequences; colours stay, and are reset at the end of a line.

    All other bytes stay, for files and pipes.
    """
    if not (0x1B in lines or 0xC2 in lines):
        return lines
    return b"\n".join(map(_closed, _escapes().sub(b"", lines).split(b"\n")))


def for_terminal(lines: bytes) -> bytes:
    """The same without all that moves the cursor and other control characters (`escapes`).

    Of a line with carriage returns (a progress bar), the part that a terminal would show last.
    """
    text = _resting(lines) if _moves(lines) else for_pipe(lines)
    if _is_ordinary(text):
        return text
    from launcher.output.escapes import without_controls

    return without_controls(text)


def _moves(lines: bytes) -> bool:
    """Whether they have carriage returns or `_SHIFTS`.

    Without a loop, which would cost more than the searches for single bytes.
    """
    return (
        0x0D in lines
        or 0x08 in lines
        or 0x0B in lines
        or 0x0C in lines
        or 0x0E in lines
        or 0x0F in lines
    )


def _resting(lines: bytes) -> bytes:
    lines = _escapes().sub(b"", lines).translate(None, _SHIFTS)
    return b"\n".join(_closed(_after_return(line)) for line in lines.split(b"\n"))


def _is_ordinary(text: bytes) -> bool:
    """Whether it is ASCII without control characters and colours."""
    return text.isascii() and not (
        0x1B in text
        or 0x07 in text
        or 0x05 in text
        or 0x11 in text
        or 0x12 in text
        or 0x13 in text
        or 0x14 in text
        or 0x18 in text
        or 0x1A in text
        or 0x7F in text
    )


@functools.cache
def _escapes() -> re.Pattern[bytes]:
    """Sequences that move the cursor, set titles or switch character sets, also incomplete ones.

    Compiled on first use, to save time before the first process.
    """
    return re.compile(
        rb"\x1b(?!\[[0-9;:]*m)(?:"
        rb"\[[0-?]*[ -/]*[@-~]?"  # CSI, but not SGR
        rb"|[\]PX^_][^\x07\x1b\n]*(?:\x07|\x1b\\)?"  # OSC, DCS, SOS, PM, APC with their text
        rb"|[ -/]+[0-~]?"  # nF: character sets
        rb"|[0-Z\\`-~]"  # Fp, Fe, Fs: two-byte sequences
        rb"|)"
        rb"|\xc2[\x90\x98\x9b\x9d-\x9f]"  # DCS, SOS, CSI, OSC, PM, APC as one character of UTF-8
    )


def _closed(line: bytes) -> bytes:
    """The line with its colour reset at the end."""
    colour = line.rfind(b"\x1b[")
    if colour < 0 or line.startswith((_RESET, b"\x1b[m"), colour):
        return line
    text = line.rstrip(b"\r")
    return text + _RESET + line[len(text) :]


def _after_return(line: bytes) -> bytes:
    return line.rstrip(b"\r").rpartition(b"\r")[2]


def without_colour(lines: bytes) -> bytes:
    return re.sub(rb"\x1b\[[0-9;:]*m", b"", lines) if 0x1B in lines else lines


_last = (b"", b"", b"")  # prefix and lines of the last block, and what became of them


def with_prefix(prefix: bytes, lines: bytes) -> bytes:
    """Every line behind `prefix`; one pass over the whole block.

    The last result is kept, since the screen and the log file of a process often get the same.
    """
    global _last
    before, block, prefixed = _last
    if block is not lines or before != prefix:
        prefixed = b"".join((prefix, lines[:-1].replace(b"\n", b"\n" + prefix), b"\n"))
        _last = prefix, lines, prefixed
    return prefixed


LIMIT_BYTES = 256 * 1024  # of memory: a process that writes line by line makes a block of each
BLOCK_BYTES = 128  # of the objects of a block, besides its lines


class Block:
    """Whole lines of one stream (`stdout`, `stderr`, `both`), read at `read_at_s` (monotonic).

    Not a Record, since one is made for every read.
    """

    __slots__ = ("lines", "read_at_s", "stream")

    def __init__(self, stream: str, read_at_s: float, lines: bytes) -> None:
        self.stream = stream
        self.read_at_s = read_at_s
        self.lines = lines


class LogRing:
    """The last output of one process, split into lines only on request. `tap` gets each block.

    It takes LIMIT_BYTES at most.
    """

    __slots__ = ("_blocks", "_bytes", "tap")

    def __init__(self) -> None:
        self._blocks: list[Block] = []  # an empty deque takes 600 bytes
        self._bytes = 0
        self.tap: Callable[[Block], None] | None = None

    def append(self, stream: str, read_at_s: float, lines: bytes) -> None:
        """Append a block, and drop the oldest beyond the limit."""
        block = Block(stream, read_at_s, lines)
        blocks = self._blocks
        blocks.append(block)
        self._bytes += len(lines) + BLOCK_BYTES
        while self._bytes > LIMIT_BYTES:
            self._bytes -= len(blocks.pop(0).lines) + BLOCK_BYTES
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
            found.append(Block(block.stream, block.read_at_s, b"\n".join(lines) + b"\n"))
        return found[::-1]

    def texts(self, most: int) -> list[str]:
        return [text for block in self.last(most) for text in texts_of(block)]


def texts_of(block: Block) -> Iterator[str]:
    for line in block.lines[:-1].split(b"\n"):
        yield line.decode(errors="replace").rstrip("\r")
