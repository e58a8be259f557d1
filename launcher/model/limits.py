"""Limits: what the system grants one process: its priority, its processors, its rlimits."""

from __future__ import annotations

from launcher.model.record import Record

UNLIMITED = -1  # as `resource.RLIM_INFINITY`


class Limits(Record):
    """None, or nothing in `rlimits`, leaves it as it is for the launcher.

    `rlimits` are (name as in `nofile`, soft, hard), each name once.
    """

    nice: int | None = None
    cpus: tuple[int, ...] | None = None
    rlimits: tuple[tuple[str, int, int], ...] = ()

    def over(self, other: Limits) -> Limits:
        """Both, where this one counts if they disagree."""
        named = {rlimit[0]: rlimit for rlimit in (*other.rlimits, *self.rlimits)}
        return Limits(
            nice=other.nice if self.nice is None else self.nice,
            cpus=other.cpus if self.cpus is None else self.cpus,
            rlimits=tuple(named.values()),
        )
