"""Control groups of robots: systemd moves its services into groups below the one it starts in."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

_ROOT = Path("/sys/fs/cgroup")


def hierarchies() -> list[Path]:
    """Those that systemd uses: named ones of hybrid machines, or the only one of cgroup v2."""
    folders = [_ROOT / "systemd", _ROOT / "unified"]
    found = [folder for folder in folders if (folder / "cgroup.procs").exists()]
    return found or [_ROOT]


def why_no_groups() -> str:
    """Why no groups can be made here; empty if they can."""
    for folder in hierarchies():
        if not os.access(folder / "cgroup.procs", os.W_OK):
            return f"control groups cannot be made in {folder}"
    return ""


def group_folders(name: str) -> list[Path]:
    return [folder / name for folder in hierarchies()]


def remove_groups(lab: str) -> bool:
    """Remove the groups of a lab; False if processes still have to leave one."""
    for folder in groups(f"{lab}.*"):
        for path, _, _ in os.walk(folder, topdown=False):
            with suppress(OSError):
                os.rmdir(path)
    return not any(groups(f"{lab}.*"))


def processes_in_groups(lab: str) -> list[int]:
    """Pids of all processes in groups of a lab."""
    pids: set[int] = set()
    # `rglob` fails if a group is removed meanwhile.
    for folder in (name for group in groups(f"{lab}.*") for name, _, _ in os.walk(group)):
        with suppress(OSError):  # it has just been removed
            pids.update(map(int, Path(folder, "cgroup.procs").read_text(encoding="ascii").split()))
    return sorted(pids)


def groups(pattern: str) -> Iterator[Path]:
    """The groups that lie directly in a hierarchy and whose names fit."""
    for folder in hierarchies():
        yield from folder.glob(pattern)
