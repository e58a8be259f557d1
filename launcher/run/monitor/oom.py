"""Detects that the kernel's OOM killer has killed a process.

Its SIGKILL looks like any other; only a counter shows it. The counter of our own control group is
exact; that of the whole machine includes processes of others.
"""

from __future__ import annotations

import os


class OomWatch:
    """Remembers the counter. `root` stands for `/` in tests."""

    def __init__(self, root: str | os.PathLike[str] = "") -> None:
        self._source = _own_group(root) or f"{root}/proc/vmstat"
        self._count = self._read()

    def has_struck(self) -> bool:
        """Whether the counter has grown since the last call."""
        before, self._count = self._count, self._read()
        return self._count > before

    def _read(self) -> int:
        counts = [words[1] for words in _lines(self._source) if words[0] == "oom_kill"]
        return int(counts[0]) if counts and counts[0].isdigit() else 0


def _lines(path: str) -> list[list[str]]:
    """The words of each line that has two; none if it cannot be read."""
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            return [words for line in file if len(words := line.split()) == 2]
    except OSError:
        return []


def _own_group(root: str | os.PathLike[str]) -> str | None:
    """`memory.events` of our control group (version 2), if there is one."""
    try:
        with open(f"{root}/proc/self/cgroup", encoding="utf-8") as file:
            lines = file.read().splitlines()
    except OSError:
        return None
    for line in lines:
        if line.startswith("0::"):
            own = f"{root}/sys/fs/cgroup/{line[3:].strip('/')}".rstrip("/")
            # The group of the run (cleanup/cgroup) has no controllers, but that around it may have.
            is_of_a_run = os.path.basename(own).startswith("launcher-")
            folders = (own, os.path.dirname(own)) if is_of_a_run else (own,)
            events = [f"{folder}/memory.events" for folder in folders]
            return next((path for path in events if os.path.isfile(path)), None)
    return None
