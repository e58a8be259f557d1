"""LineBuffer: bytes as they are read, made into whole lines that are safe to show."""

from __future__ import annotations

import functools
import re

LINE_LIMIT = 64 * 1024  # bytes; a longer line is cut here
CUT_MARK = b" [... cut by the launcher]"

_RESET = b"\x1b[0m"

_SHIFTS = b"\x08\x0b\x0c\x0e\x0f"  # backspace, vertical tab, form feed, character sets


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
        end = chunk.rfind(b"\n") + 1
        if not end:
            self._hold(chunk)
            return b"", 0
        begin = chunk.index(b"\n") if self._overlong else 0
        lines, shown = self.partial + chunk[begin:end], self.shown
        self._forget()
        if end < len(chunk):
            self._hold(chunk[end:])
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


def _is_harmless(lines: bytes) -> bool:
    """Whether there is nothing in them that needs a closer look.

    Written out: a search for one byte costs next to nothing, a loop around it more.
    """
    return not (
        0x1B in lines
        or 0x0D in lines
        or 0xC2 in lines
        or 0x08 in lines
        or 0x0B in lines
        or 0x0C in lines
        or 0x0E in lines
        or 0x0F in lines
    )


def for_screen(lines: bytes) -> bytes:
    """Whole lines without what would move the reader's cursor; colour stays, inside its line.

    A carriage return before the newline goes; one inside a line (a progress bar) leaves what a
    terminal would show last.
    """
    if _is_harmless(lines):
        return lines
    lines = _escapes().sub(b"", lines).translate(None, _SHIFTS)
    return b"\n".join(_closed(_after_return(line)) for line in lines.split(b"\n"))


def for_terminal(lines: bytes) -> bytes:
    """The same for a screen that is a terminal, which obeys more than that (`terminal`)."""
    text = for_screen(lines)
    if _is_ordinary(text):
        return text
    from launcher.engine.terminal import without_controls

    return without_controls(text)


def _is_ordinary(text: bytes) -> bool:
    """Whether there is nothing in it that a terminal could obey; written out for the same reason.

    Bytes that are no ASCII need a closer look, and so do colours.
    """
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
    """What moves the cursor, sets titles or switches character sets, complete or not; not colour.

    Compiled when it is first needed, like all patterns on the way to the first process.
    """
    return re.compile(
        rb"\x1b(?!\[[0-9;:]*m)(?:"
        rb"\[[0-?]*[ -/]*[@-~]?"  # CSI, but not SGR
        rb"|[\]PX^_][^\x07\x1b\n]*(?:\x07|\x1b\\)?"  # OSC, DCS, SOS, PM, APC with their text
        rb"|[ -/]+[0-~]?"  # nF: character sets
        rb"|[0-Z\\`-~]"  # Fp, Fe, Fs: two-byte sequences
        rb"|)"
        rb"|\xc2[\x80-\x9f]"  # the same controls as one character of UTF-8
    )


def _closed(line: bytes) -> bytes:
    """The line with its colour switched off at the end."""
    colour = line.rfind(b"\x1b[")
    if colour < 0 or line.startswith((_RESET, b"\x1b[m"), colour):
        return line
    return line + _RESET


def _after_return(line: bytes) -> bytes:
    return line.rstrip(b"\r").rpartition(b"\r")[2]


def with_prefix(prefix: bytes, lines: bytes) -> bytes:
    """Every line behind `prefix`; one pass over the whole block."""
    return prefix + lines[:-1].replace(b"\n", b"\n" + prefix) + b"\n"
