"""Sleepers: why a process does not go, in the words of the kernel."""

from __future__ import annotations

import os

_STATES = {
    "D": "uninterruptible sleep",
    "Z": "a zombie",
    "T": "stopped",
    "t": "traced",
    "R": "running",
    "S": "sleeping",
}


def how_it_sleeps(pid: int) -> str:
    """`state D (uninterruptible sleep), in nfs_wait`; the place only where the kernel tells it."""
    state = _state(pid)
    if state is None:
        return "gone in this moment"
    named = f"state {state} ({_STATES.get(state, 'see man 5 proc')})"
    place = _place(pid)
    where = f", in {place}" if place else ""
    return f"{named}{where}{_owner(pid)}"


def _owner(pid: int) -> str:
    """Whose it is, where that is why our signals do not count (sudo)."""
    try:
        owner = os.stat(f"/proc/{pid}").st_uid
    except OSError:
        return ""
    return "" if os.geteuid() in (0, owner) else f", belongs to user {owner}, who may end it"


def _state(pid: int) -> str | None:
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as file:
            return file.read().rpartition(")")[2].split()[0]
    except (OSError, IndexError):
        return None


def _place(pid: int) -> str:
    """The function of the kernel that it waits in; "" where that is a secret."""
    try:
        with open(f"/proc/{pid}/wchan", encoding="ascii", errors="replace") as file:
            return file.read().strip("\0\n 0")
    except OSError:
        return ""
