"""Keys: what a terminal sends for a key, where prompt_toolkit is not at work."""

from __future__ import annotations

import re

_SEQUENCE = re.compile(r"\x1b\[[0-9;]*[A-Za-z~]|\x1bO[A-Za-z]|.", re.DOTALL)
_NAMES = {
    "\x1b[A": "up",
    "\x1bOA": "up",
    "k": "up",
    "\x1b[B": "down",
    "\x1bOB": "down",
    "j": "down",
    "\x1b[5~": "pageup",
    "\x1b[6~": "pagedown",
    " ": "pagedown",
    "\x1b[H": "home",
    "\x1bOH": "home",
    "\x1b[1~": "home",
    "\x1b[F": "end",
    "\x1bOF": "end",
    "\x1b[4~": "end",
}


def keys(typed: str) -> list[str]:
    """The names of the keys that were typed; of those without a name, what they sent."""
    return [_NAMES.get(one, one) for one in _SEQUENCE.findall(typed)]
