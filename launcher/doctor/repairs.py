"""Repairs: what `doctor --fix` does. Each says what it did, in sentences."""

from __future__ import annotations

from collections.abc import Iterable

from launcher.doctor.facts import Facts
from launcher.engine.cleanup.leftovers import Leftovers, patience_for
from launcher.engine.monitor import shared_memory
from launcher.engine.monitor.shared_memory import Stale
from launcher.engine.posix.reactor import Reactor


def repair(facts: Facts) -> list[str]:
    """Mend what can be mended: processes first, since they may leave shared memory."""
    said = end_runs({leftover.run_id for leftover in facts.leftovers})
    # Looked for anew: an ended process may have left something, or have freed it.
    return said + free(shared_memory.stale())


def end_runs(run_ids: Iterable[str]) -> list[str]:
    """Stop everything that carries these run ids: SIGINT, SIGTERM, SIGKILL, with deadlines."""
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


def free(items: list[Stale]) -> list[str]:
    """Free shared memory that nobody uses."""
    freed_bytes = shared_memory.clean(items)
    return [f"freed {freed_bytes / 1024**2:.1f} MiB of shared memory"] if freed_bytes else []
