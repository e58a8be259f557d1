"""The log folders of runs that are over: which are deleted, and which hold evidence and stay."""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
from collections.abc import Iterator

from launcher.base.model.event_entries import entry_in
from launcher.base.model.run_events import Finished
from launcher.output.logs.run_directory import EVENTS

KEPT_RUNS = 20
EVIDENCE = "smoke"  # beside the runs: what `smoke` keeps of those that have failed
_RUN_NAME = r"\d{4}(-\d\d){5}-\d{6}-.*-\d+$"
_RECORDINGS = ("snapshots", "bag")  # of the flight recorder
_TAIL_BYTES = 4096  # the last entry is far shorter


def prune(path: str, keep: int = KEPT_RUNS) -> Iterator[None]:
    """Delete our oldest runs beside this one, one in each step, all but the last `keep`.

    Those that go on or hold evidence stay.
    """
    root, own_name = os.path.split(path)
    for name in runs(root)[:-keep]:
        old = os.path.join(root, name)
        if name != own_name and not holds_evidence(old) and not _is_active(old):
            _remove(old)
        yield


def kept_beyond(root: str, keep: int = KEPT_RUNS) -> list[str]:
    """The folders of runs older than the last `keep` that stay, the oldest first; OSError."""
    older = (os.path.join(root, name) for name in runs(root)[:-keep])
    return [run for run in older if holds_evidence(run)]


def runs(root: str) -> list[str]:
    """The names of ours, the oldest first; OSError.

    `ros2 launch` has its runs there, too, without an events file.
    """
    names = sorted(name for name in os.listdir(root) if re.match(_RUN_NAME, name))
    return [name for name in names if os.path.isfile(f"{root}/{name}/{EVENTS}")]


def holds_evidence(run: str) -> bool:
    """Whether a run has failed, a process of it has died, or it was recorded."""
    if any(os.path.isdir(f"{run}/{name}") for name in _RECORDINGS):
        return True
    line = _last_line(f"{run}/{EVENTS}")
    entry = None if line is None else entry_in(line)
    if entry is not None and isinstance(entry.event, Finished):
        return entry.event.exit_code != 0 or entry.event.deaths > 0
    return line is not None  # its launcher was killed; else nothing was started


def _last_line(path: str) -> bytes | None:
    """Empty if it cannot be read; None if there is none."""
    try:
        with open(path, "rb") as file:
            file.seek(max(0, os.fstat(file.fileno()).st_size - _TAIL_BYTES))
            lines = file.read().splitlines()
    except OSError:
        return b""
    if lines or os.path.exists(f"{path}.1"):
        return lines[-1] if lines else b""
    return None


def _is_active(run: str) -> bool:
    """Whether the launcher of this run still holds its lock."""
    try:
        with open(f"{run}/{EVENTS}") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return True
    return False


def _remove(folder: str) -> None:
    """As `shutil.rmtree`, which is slow to import because of its compressors; ignores errors."""
    for path, folders, files in os.walk(folder, topdown=False):
        for name in files:
            with contextlib.suppress(OSError):
                os.unlink(f"{path}/{name}")
        for name in folders:
            inner = f"{path}/{name}"
            with contextlib.suppress(OSError):
                (os.unlink if os.path.islink(inner) else os.rmdir)(inner)
    with contextlib.suppress(OSError):
        os.rmdir(folder)
