"""Voice: standard output that may go away while a run goes on and has to end in order."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import TextIO


class Voice(io.TextIOBase):
    """Writes to a stream until that refuses, and is silent afterwards.

    A reader that has gone (`smoke ... | head`) is no failure; `trouble` tells any other.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._is_silent = False
        self.trouble: str | None = None

    @property
    def encoding(self) -> str:  # type: ignore[override]  # an attribute there
        """That of the stream, which decides what can be drawn."""
        return self._stream.encoding

    def write(self, text: str) -> int:
        """All of it, or as much as somebody takes."""
        self._attempt(lambda: self._stream.write(text))
        return len(text)

    def flush(self) -> None:
        """Now."""
        self._attempt(self._stream.flush)

    def isatty(self) -> bool:
        """Whether the stream is a terminal."""
        return self._stream.isatty()

    def _attempt(self, work: Callable[[], object]) -> None:
        if self._is_silent:
            return
        try:
            work()
        except BrokenPipeError:
            self._is_silent = True
        except OSError as error:
            self._is_silent = True
            self.trouble = error.strerror
