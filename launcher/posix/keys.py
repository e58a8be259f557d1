"""The keys that are typed on the terminal of standard input, by name."""

from __future__ import annotations

import os
import re

READ_BYTES = 1024
# Not by prompt_toolkit's parser, whose import takes longer than the first answer of a run.
_SEQUENCE = re.compile(r"\x1b\[[0-9;]*[A-Za-z~]|\x1bO[A-Za-z]|.", re.DOTALL)
_LETTERS = {"A": "up", "B": "down", "C": "right", "D": "left", "H": "home", "F": "end"}
_NUMBERS = {"1": "home", "4": "end", "5": "pageup", "6": "pagedown"}
_NAMES = {
    **{f"\x1b{lead}{letter}": name for lead in "[O" for letter, name in _LETTERS.items()},
    **{f"\x1b[{number}~": name for number, name in _NUMBERS.items()},
}


def parse_keys(typed: str) -> list[str]:
    """Names of the keys that were typed; keys without a name stand for themselves."""
    return [_NAMES.get(one, one) for one in _SEQUENCE.findall(typed)]


def read_keys() -> list[str]:
    """Those that have been typed by now; none if the terminal was closed."""
    try:
        return parse_keys(os.read(0, READ_BYTES).decode(errors="replace"))
    except OSError:
        return []
