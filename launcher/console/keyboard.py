"""Keyboard: what a person types, without what is no text and no key of ours."""

from __future__ import annotations

import sys

from prompt_toolkit.input.posix_utils import PosixStdinReader
from prompt_toolkit.input.vt100 import Vt100Input
from prompt_toolkit.key_binding import KeyPress
from prompt_toolkit.keys import Keys

# NUL would mark a region, and every key after that would be meant for the region.
_NO_KEYS = (Keys.ControlAt,)


class Keyboard(Vt100Input):
    """The terminal on standard input; bytes that are no text in its encoding show as U+FFFD."""

    def __init__(self) -> None:
        super().__init__(sys.stdin)
        self.stdin_reader = PosixStdinReader(
            self.fileno(), errors="replace", encoding=sys.stdin.encoding
        )

    def read_keys(self) -> list[KeyPress]:
        """What was typed since the last time."""
        return [press for press in super().read_keys() if press.key not in _NO_KEYS]
