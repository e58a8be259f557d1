"""The repairs of `doctor --fix`; each function returns messages about what it did."""

from __future__ import annotations

import functools
from collections.abc import Iterable

from launcher import proc
from launcher.doctor.checks import MB
from launcher.doctor.facts import Facts
from launcher.engine.cleanup import cgroup
from launcher.engine.cleanup.leftovers import Leftovers, stop_policy_for
from launcher.engine.cleanup.run_id import abandoned_groups
from launcher.engine.monitor import shared_memory
from launcher.engine.posix.reactor import Reactor


def repair(facts: Facts) -> list[str]:
    """Stop leftover processes first, since they may leave shared memory, and free that."""
    lines = stop_runs({leftover.run_id for leftover in facts.leftovers})
    lines += [f"removed {path}" for path in facts.stale_groups if cgroup.Cgroup(path).remove()]
    # Listed again: the processes may have left more, or freed something.
    freed_bytes = shared_memory.free(item.name for item in shared_memory.settled())
    if freed_bytes:
        lines.append(f"freed {freed_bytes / MB:.1f} MiB of shared memory")
    return lines


def stop_runs(run_ids: Iterable[str]) -> list[str]:
    """Stop all processes with these run ids: SIGINT, SIGTERM, SIGKILL, with deadlines."""
    lines: list[str] = []
    groups = dict(abandoned_groups())
    for run_id in sorted(run_ids):
        group = groups.get(run_id)
        with Reactor() as reactor:
            Leftovers(
                run_id,
                reactor=reactor,
                listener=_RepairListener(reactor, lines),
                ignore=frozenset(),
                policy=stop_policy_for(()),
                kin=dict if group is None else functools.partial(_members, group),
            ).check()
            reactor.run()
    return lines


def _members(group: cgroup.Cgroup) -> dict[int, int]:
    """Pid -> start of the processes in a stale group."""
    starts = {pid: proc.start_ticks(pid) for pid in group.pids()}
    return {pid: start for pid, start in starts.items() if start is not None}


class _RepairListener:
    def __init__(self, reactor: Reactor, lines: list[str]) -> None:
        self._lines = lines
        self.finished = reactor.stop

    def log(self, level: str, text: str) -> None:
        self._lines.append(text)

    def killing(self) -> None:
        pass
