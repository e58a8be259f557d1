"""A line at the bottom of a terminal that is written again and again."""

from __future__ import annotations

import os
from typing import TextIO

from launcher.base.text import escape

_MIN_WIDTH = 40


class BuildStatusLine:
    """Writes nothing where the stream is not a terminal, or a narrow one."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._shown = ""

    def write(self, text: str) -> None:
        """Show the text, shortened to the width of the terminal, in place of the last one."""
        width = self._width()
        text = escape(text)
        text = text if len(text) < width else text[: width - 2] + "…"
        if width >= _MIN_WIDTH and text != self._shown:
            self._put(text)

    def clear(self) -> None:
        """Remove the line, so that other lines can be printed."""
        if self._shown:
            self._put("")

    def _put(self, text: str) -> None:
        self._stream.write(f"\r{text}\x1b[K")
        self._stream.flush()
        self._shown = text

    def _width(self) -> int:
        """Columns of the terminal; 0 where no line can be written anew."""
        try:
            if not self._stream.isatty() or os.environ.get("TERM") == "dumb":
                return 0
            return os.get_terminal_size(self._stream.fileno()).columns
        except (OSError, ValueError):
            return 0
