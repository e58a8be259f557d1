"""The repairs of `doctor --fix`; each function returns messages about what it did."""

from __future__ import annotations

from collections.abc import Iterable

from launcher.doctor.checks import MB
from launcher.doctor.doctor_facts import DoctorFacts
from launcher.posix import proc
from launcher.posix.cleanup import cgroup, run_id, sweep
from launcher.posix.reactor import Reactor
from launcher.run.ending.leftovers import Leftovers, stop_policy_for
from launcher.run.monitor import shared_memory


def repair(facts: DoctorFacts) -> list[str]:
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
    groups = dict(run_id.abandoned_groups())
    for one in sorted(run_ids):
        with Reactor() as reactor:
            Leftovers(
                one,
                reactor=reactor,
                listener=_RepairListener(reactor, lines),
                ignore=frozenset(),
                policy=stop_policy_for(()),
                kin=_Kin(one, groups.get(one)),
            ).check()
            reactor.run()
    return lines


class _Kin:
    """Pid -> start of the processes of a run.

    Descendants are remembered: they cannot be found any more when what is between has ended.
    """

    def __init__(self, run_id: str, group: cgroup.Cgroup | None) -> None:
        self._run_id = run_id
        self._group = group
        self._known: dict[int, int] = {}

    def __call__(self) -> dict[int, int]:
        found, _ = sweep.find(self._run_id, kin=self._known)
        self._known |= run_id.kin(found, self._run_id)
        if self._group is not None:
            self._known |= proc.family(self._group.pids())
        return self._known


class _RepairListener:
    def __init__(self, reactor: Reactor, lines: list[str]) -> None:
        self._lines = lines
        self.finished = reactor.stop

    def report(self, level: str, text: str) -> None:
        self._lines.append(text)

    def killing(self) -> None:
        pass
