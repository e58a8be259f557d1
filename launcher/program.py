"""The name of the program in usages and hints."""

from __future__ import annotations

import os
import sys

SCRIPT = "launcher"


def program() -> str:
    """`launcher` if that command was started, `python -m launcher` otherwise."""
    return SCRIPT if os.path.basename(sys.argv[0]) == SCRIPT else f"python -m {SCRIPT}"
