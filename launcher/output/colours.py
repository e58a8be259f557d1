"""Whether output is coloured."""

from __future__ import annotations

import os
from collections.abc import Mapping


def wants_colour(fd: int, env: Mapping[str, str]) -> bool:
    """Whether output to `fd` is coloured: NO_COLOR, then FORCE_COLOR, then whether it is a tty."""
    if env.get("NO_COLOR"):
        return False
    if env.get("FORCE_COLOR"):
        return env["FORCE_COLOR"] != "0"
    return os.isatty(fd) and env.get("TERM") != "dumb"


def passes_colour(fd: int, env: Mapping[str, str]) -> bool:
    """Whether the colours of processes reach the output.

    As for our own, but RCUTILS_COLORIZED_OUTPUT=1 keeps them in a pipe, too (CONFORMANCE 1.34).
    """
    if env.get("NO_COLOR") or env.get("FORCE_COLOR"):
        return wants_colour(fd, env)
    return env.get("RCUTILS_COLORIZED_OUTPUT") == "1" or wants_colour(fd, env)
