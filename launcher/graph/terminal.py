"""Terminal: what nodes say is shown there, and does not steer it."""

from __future__ import annotations

import contextlib
import re
import sys
from collections.abc import Iterator
from typing import Any, TextIO, cast

# Everything that a terminal takes for a command; with it a message could retitle a window, hide
# lines or, in some terminals, type. Line ends and tabs are text.
_STEERING = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")


def without_commands(text: str) -> str:
    """The text with control characters as escapes: `\\x1b`."""
    return _STEERING.sub(lambda match: f"\\x{ord(match[0]):02x}", text)


class _Harmless:
    """A stream to a terminal."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write what is harmless."""
        self._stream.write(without_commands(text))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextlib.contextmanager
def harmless() -> Iterator[None]:
    """Inside, nothing that is printed steers a terminal; files and pipes get every byte."""
    kept = sys.stdout, sys.stderr
    guarded = [cast("TextIO", _Harmless(s)) if s and s.isatty() else s for s in kept]
    sys.stdout, sys.stderr = guarded
    try:
        yield
    finally:
        if sys.stdout is guarded[0]:  # somebody may have put it away for good
            sys.stdout = kept[0]
        sys.stderr = kept[1]
