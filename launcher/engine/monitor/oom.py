"""Detects that the kernel's OOM killer has killed a process.

Its SIGKILL looks like any other; only a counter shows it. The counter of our own control group is
exact; that of the whole machine includes processes of others.
"""

from __future__ import annotations

from pathlib import Path


class OomWatch:
    """Remembers the counter. `root` stands for `/` in tests."""

    def __init__(self, root: Path = Path("/")) -> None:
        self._source = _own_group(root) or root / "proc/vmstat"
        self._count = self._read()

    def has_struck(self) -> bool:
        """Whether the counter has grown since the last call."""
        before, self._count = self._count, self._read()
        return self._count > before

    def _read(self) -> int:
        try:
            lines = self._source.read_text(encoding="utf-8", errors="replace").splitlines()
        except OSError:
            return 0
        counts = [line.split()[1] for line in lines if line.startswith("oom_kill ")]
        return int(counts[0]) if counts and counts[0].isdigit() else 0


def _own_group(root: Path) -> Path | None:
    """`memory.events` of our control group (version 2), if there is one."""
    try:
        lines = (root / "proc/self/cgroup").read_text(encoding="utf-8").splitlines()
    except OSError:
        return None
    for line in lines:
        if line.startswith("0::"):
            own = root / "sys/fs/cgroup" / line[3:].lstrip("/")
            # The group of the run (cleanup/cgroup) has no controllers, but that around it may have.
            folders = (own, own.parent) if own.name.startswith("launcher-") else (own,)
            events = [folder / "memory.events" for folder in folders]
            return next((path for path in events if path.is_file()), None)
    return None
