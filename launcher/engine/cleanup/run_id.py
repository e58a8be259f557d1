"""RunId: which run a process belongs to, and whether the launcher of that run still lives.

A run id is `PID-RANDOM` with the launcher's pid; every descendant carries it in its environment
(`sweep.RUN_ID_VARIABLE`). Reading it is cheap and needs nothing but /proc.
"""

from __future__ import annotations

import os
from pathlib import Path

from launcher.engine.cleanup.sweep import RUN_ID_VARIABLE

PROC = Path("/proc")
_ENTRY = f"{RUN_ID_VARIABLE}=".encode()
_START_FIELD = 19  # of /proc/PID/stat behind the command's closing parenthesis


def run_id_of(pid: int, *, proc: Path = PROC) -> str | None:
    """The run id in the environment of `pid`; None if it has none, is a zombie or not ours."""
    try:
        entries = (proc / str(pid) / "environ").read_bytes().split(b"\0")
    except OSError:
        return None
    found = next((entry for entry in entries if entry.startswith(_ENTRY)), None)
    return None if found is None else os.fsdecode(found[len(_ENTRY) :])


def is_abandoned(pid: int, run_id: str, *, proc: Path = PROC) -> bool:
    """Whether `pid`, which carries `run_id`, has outlived its launcher.

    In doubt it has not: the id is no pid, or the process lives in another pid namespace, where
    its launcher has another number than here.
    """
    text, _, _ = run_id.partition("-")
    if not text.isdigit() or _namespace(pid, proc) != _namespace(os.getpid(), proc):
        return False
    started, launcher_started = _start_ticks(pid, proc), _start_ticks(int(text), proc)
    if started is None:
        return False  # it is gone itself
    # Whoever has that pid and is younger than the process got a number that was given out again.
    return launcher_started is None or launcher_started > started


def abandoned_runs(*, proc: Path = PROC) -> dict[str, list[int]]:
    """Run id -> pids of all processes whose launcher is gone.

    The run that we are part of ourselves is left out: its terminal may be the one we run in.
    """
    ours = run_id_of(os.getpid(), proc=proc)
    runs: dict[str, list[int]] = {}
    for name in filter(str.isdigit, os.listdir(proc)):
        run_id = run_id_of(int(name), proc=proc)
        if run_id is None or run_id == ours:
            continue
        if is_abandoned(int(name), run_id, proc=proc):
            runs.setdefault(run_id, []).append(int(name))
    return runs


def _namespace(pid: int, proc: Path) -> str | None:
    try:
        return os.readlink(proc / str(pid) / "ns" / "pid")
    except OSError:
        return None


def _start_ticks(pid: int, proc: Path) -> int | None:
    """When the process started, in clock ticks since boot; None if there is none (or a zombie)."""
    try:
        text = (proc / str(pid) / "stat").read_bytes()
    except OSError:
        return None
    state, *fields = text[text.rindex(b")") + 1 :].split()
    return None if state in (b"Z", b"X") else int(fields[_START_FIELD - 1])
