"""The cause of a fault."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Cause:
    """One sentence, the rule that has found it, when it happened, in time of the run.

    `about`: the processes, nodes and topics that it has to do with; `machine` for all of them.
    `is_weak`: another rule may explain the fault a moment later.
    """

    rule: str
    text: str
    at_s: float
    about: frozenset[str] = frozenset()
    is_weak: bool = False

    @property
    def key(self) -> tuple[str, frozenset[str]]:
        """The same for faults that have it in common."""
        return self.rule, self.about


MACHINE = "machine"
BEFORE_S = 12.0  # a cause is at most so much earlier than its fault,
LATER_S = 2.5  # and is seen at most so much later
OF_TIME = ("rate", "gap", "latency")  # kinds of faults that depend on processor time
