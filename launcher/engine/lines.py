"""LineBuffer: bytes as they are read, made into whole lines that are safe to show."""

from __future__ import annotations

import re

LINE_LIMIT = 64 * 1024  # bytes; a longer line is cut here
CUT_MARK = b" [... cut by the launcher]"

# Control sequences other than colour (`ESC [ ... m`): cursor movement, titles, and single escapes.
_CONTROL = re.compile(
    rb"\x1b(?:"
    rb"\[[0-?]*[ -/]*[@-ln-~]"  # CSI, but not SGR
    rb"|[\]PX^_][^\x07\x1b]*(?:\x07|\x1b\\)"  # OSC, DCS, SOS, PM, APC with their text
    rb"|[ -/]+[0-~]"  # nF: character sets
    rb"|[0-OQ-WYZ\\`-~]"  # Fp, Fe, Fs: two-byte sequences
    rb")"
)


class LineBuffer:
    """Collects one stream of one process; holds back what is not a whole line yet.

    `shown` counts the bytes of the waiting line that somebody has shown already, for a prompt
    that will get its newline later.
    """

    def __init__(self) -> None:
        self.partial = b""
        self.shown = 0
        self._overlong = False

    def feed(self, chunk: bytes) -> tuple[bytes, int]:
        """(whole lines that `chunk` completes, bytes of the first that are shown already)."""
        head, newline, tail = chunk.rpartition(b"\n")
        if not newline:
            self._hold(chunk)
            return b"", 0
        block = head + newline
        if self._overlong:
            block = block[block.index(b"\n") :]
        lines, shown = self.partial + block, self.shown
        self._forget()
        self._hold(tail)
        if len(lines) > LINE_LIMIT:
            lines = b"".join(_cut(line + b"\n") for line in lines[:-1].split(b"\n"))
        return lines, shown

    def take_partial(self) -> tuple[bytes, int]:
        """What waits for its end, made a line, as `feed` returns it; b'' if nothing waits."""
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


def _cut(line: bytes) -> bytes:
    longest = LINE_LIMIT + len(CUT_MARK) + 1  # `_hold` may have cut it before
    return line if len(line) <= longest else line[:LINE_LIMIT] + CUT_MARK + b"\n"


def for_screen(lines: bytes) -> bytes:
    """Whole lines without what would move the reader's cursor; colour stays.

    A carriage return before the newline goes; one inside a line (a progress bar) leaves what a
    terminal would show last.
    """
    if b"\x1b" in lines:
        lines = _CONTROL.sub(b"", lines)
    if b"\r" in lines:
        lines = b"\n".join(_after_return(line) for line in lines.split(b"\n"))
    return lines


def _after_return(line: bytes) -> bytes:
    return line.rstrip(b"\r").rpartition(b"\r")[2]


def with_prefix(prefix: bytes, lines: bytes) -> bytes:
    """Every line behind `prefix`; one pass over the whole block."""
    return prefix + lines[:-1].replace(b"\n", b"\n" + prefix) + b"\n"
