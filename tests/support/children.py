"""Processes and their children, of which some may end while they are looked at."""

from __future__ import annotations

import contextlib

import psutil


def is_alive(pid: int) -> bool:
    """Whether there is such a process, and it is not a zombie."""
    try:
        return psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


def children(pid: int) -> list[int]:
    """Pids of its children, zombies included; none of a process that has ended."""
    try:
        return [child.pid for child in psutil.Process(pid).children()]
    except psutil.NoSuchProcess:
        return []


def children_named(pid: int, name: str) -> list[int]:
    """Pids of those that run this program."""
    found = []
    for child in children(pid):
        with contextlib.suppress(psutil.NoSuchProcess):
            if psutil.Process(child).name() == name:
                found.append(child)
    return found


def children_with(pid: int, word: str) -> list[psutil.Process]:
    """Those with this in a word of their command line, zombies left out."""
    found = []
    with contextlib.suppress(psutil.NoSuchProcess):  # the process itself has ended
        for child in psutil.Process(pid).children():
            with contextlib.suppress(psutil.NoSuchProcess):
                if any(word in one for one in child.cmdline()):
                    found.append(child)
    return found
