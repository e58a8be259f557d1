"""Children of a process, of which some may end while they are looked at."""

from __future__ import annotations

import contextlib

import psutil


def children_with(pid: int, word: str) -> list[psutil.Process]:
    """Those with this in a word of their command line, zombies left out."""
    found = []
    with contextlib.suppress(psutil.NoSuchProcess):  # the process itself has ended
        for child in psutil.Process(pid).children():
            with contextlib.suppress(psutil.NoSuchProcess):
                if any(word in one for one in child.cmdline()):
                    found.append(child)
    return found
