"""What `doctor --fix` does; each function returns sentences about what it did."""

from __future__ import annotations

from collections.abc import Iterable

from launcher.doctor.checks import MB
from launcher.doctor.facts import Facts
from launcher.engine.cleanup.leftovers import Leftovers, patience_for
from launcher.engine.monitor import shared_memory
from launcher.engine.posix.reactor import Reactor


def repair(facts: Facts) -> list[str]:
    """Stop leftover processes first, since they may leave shared memory, and free that."""
    said = end_runs({leftover.run_id for leftover in facts.leftovers})
    # Listed again: the processes may have left more, or freed something.
    freed_bytes = shared_memory.clean(shared_memory.stale())
    return [*said, *([f"freed {freed_bytes / MB:.1f} MiB of shared memory"] if freed_bytes else [])]


def end_runs(run_ids: Iterable[str]) -> list[str]:
    """Stop all processes with these run ids: SIGINT, SIGTERM, SIGKILL, with deadlines."""
    said: list[str] = []
    for run_id in sorted(run_ids):
        with Reactor() as reactor:
            Leftovers(
                run_id,
                reactor=reactor,
                listener=_Repair(reactor, said),
                ignore=frozenset(),
                patience=patience_for(()),
            ).check()
            reactor.run()
    return said


class _Repair:
    """Hears what becomes of the leftovers of a run."""

    def __init__(self, reactor: Reactor, lines: list[str]) -> None:
        self._lines = lines
        self.gone = reactor.stop

    def said(self, level: str, text: str) -> None:
        self._lines.append(text)

    def killed(self) -> None:
        """No-op."""
