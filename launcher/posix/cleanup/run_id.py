"""Which run a process belongs to, and whether the launcher of that run is still running.

A run id is `PID-RANDOM` with the launcher's pid; every descendant carries it in its environment
(RUN_ID_VARIABLE).
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator

from launcher.posix import proc
from launcher.posix.cleanup import RUN_ID_VARIABLE, cgroup

JOIN_S = 10.0  # between the making of a control group and the first process in it: far less


def run_id_of(pid: int) -> str | None:
    """The run id in the environment of `pid`; None if it has none, is a zombie or not ours."""
    prefix = f"{RUN_ID_VARIABLE}=".encode()
    for entry in proc.environment(pid):
        if entry.startswith(prefix):
            return os.fsdecode(entry[len(prefix) :])
    return None


def is_abandoned(pid: int, run_id: str) -> bool:
    """Whether `pid`, which carries `run_id`, has outlived its launcher.

    False if that is unknown: the id has no pid, or the process is in another pid namespace, where
    its launcher has another pid than here.
    """
    text, _, _ = run_id.partition("-")
    if not text.isdigit() or proc.pid_namespace(pid) != proc.pid_namespace(os.getpid()):
        return False
    started, launcher_started = proc.start_ticks(pid), proc.start_ticks(int(text))
    if started is None:
        return False  # it has just exited
    # A younger process with that pid is not the launcher: the pid was reused.
    return launcher_started is None or launcher_started > started


def abandoned_runs() -> dict[str, list[int]]:
    """Run id -> pids of all processes whose launcher has exited.

    They have the run id, or descend from such a process, or are in the control group of the run.
    Without the run that this process is part of: its terminal may be the one we run in.
    """
    ours = run_id_of(os.getpid())
    runs: dict[str, list[int]] = {}
    for pid in proc.pids():
        run_id = run_id_of(pid)
        if run_id is not None and run_id != ours and is_abandoned(pid, run_id):
            runs.setdefault(run_id, []).append(pid)
    for run_id, found in runs.items():
        found += sorted(kin(found, run_id).keys() - set(found))
    for run_id, group in abandoned_groups():
        pids = runs.setdefault(run_id, [])
        pids += (pid for pid in group.pids() if pid not in pids)
    around = set(ancestors())
    return {run_id: pids for run_id, pids in runs.items() if pids and around.isdisjoint(pids)}


def kin(pids: Iterable[int], run_id: str) -> dict[int, int]:
    """Pid -> start of these processes of a run, and of their descendants.

    Those that have cleared their environment are included, those of another run are not.
    """
    family = proc.family(pids)
    return {pid: start for pid, start in family.items() if run_id_of(pid) in (None, run_id)}


def ancestors(pid: int | None = None) -> Iterator[int]:
    """The parent of a process, by default of this one, and so on."""
    parent = os.getppid() if pid is None else int(proc.status_field(pid, "PPid") or 0)
    while parent:
        yield parent
        parent = int(proc.status_field(parent, "PPid") or 0)


def abandoned_groups() -> list[tuple[str, cgroup.Cgroup]]:
    """(run id, control group) of runs whose launcher has exited.

    A launcher that stops its run has left the group.
    """
    return [(run_id, group) for run_id, group in cgroup.groups() if _is_stale(run_id, group)]


def _is_stale(run_id: str, group: cgroup.Cgroup) -> bool:
    pids = group.pids()
    if not pids:  # of another pid namespace, maybe, whose pids say nothing here
        return group.age_s() > JOIN_S
    # Also False for 0, a process of another pid namespace.
    return os.getpid() not in pids and all(pid and is_abandoned(pid, run_id) for pid in pids)
