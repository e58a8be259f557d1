"""At the end of a run: that nodes were run by a Python without rclpy, where ours has it."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable

from launcher.base.text import several
from launcher.packages import python_program
from launcher.run.processes.process import Process

_LAST_LINES = 10
_MAX_NAMES = 3
_ERROR = re.compile(r"^ModuleNotFoundError: No module named 'rclpy'", re.MULTILINE)


def lacking(processes: Iterable[Process]) -> str | None:
    """Which interpreter has run the processes that died of it, and what to do; None if none has."""
    found: dict[str, list[str]] = {}  # interpreter -> processes
    for one in processes:
        if one.host is None and one.history.deaths and _is_without(one):
            path = python_program.interpreter_of(one.spec.argv, one.spec.env, one.spec.cwd)
            if path is not None and not python_program.is_ours(path):
                found.setdefault(path, []).append(one.name)
    if not found or not _has_rclpy():
        return None
    path, names = next(iter(found.items()))
    were = "were" if len(names) > 1 else "was"
    activate = os.path.join(os.path.dirname(sys.executable), "activate")
    first = f"write '#!{sys.executable}' into its first line"
    return (
        f"{several(names, _MAX_NAMES)} {were} run by {path}, which has no rclpy; "
        f"{sys.executable} has: "
        + (f". {activate} before the start, or {first}" if os.path.isfile(activate) else first)
    )


def _is_without(process: Process) -> bool:
    return _ERROR.search("\n".join(process.last_lines(_LAST_LINES))) is not None


def _has_rclpy() -> bool:
    from launcher.packages.absent_ros import has_ros

    return has_ros()
