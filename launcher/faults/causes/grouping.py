"""Incidents: faults that have one cause, or that follow from another."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from launcher.faults.causes.cause import MACHINE, Cause
from launcher.faults.model.fault import Fault
from launcher.faults.watcher.story import Story

MOST_INCIDENTS = 200  # of a run that are kept: of a fault that comes and goes for days, the newest
TOGETHER_S = 2.0  # after an incident is over, what follows from it may still be seen
# Kinds of faults that are causes themselves: those that have the same cause follow from them.
LEADING = ("reachable", "no deaths", "not suspended", "one node of a name", "QoS", "disk", "clock")
# Rules of causes that go on to do harm; others are due to what has happened at about their time.
LASTING = frozenset(
    (
        "clock step",
        "full disk",
        "lost link",
        "request",
        "suspension",
        "slow process",
        "double node",
        "QoS",
        "death",
        "busy process",
        "starvation",
    )
)
FOLLOWS_S = 5.0
DERIVED = ("restart", "death", "request")  # rules whose causes explain others of the same process


@dataclass(slots=True)
class Incident:
    """The first of `faults` is the root; `closed_s` is when all of them were healed."""

    number: int
    opened_s: float
    faults: list[Fault]
    causes: list[Cause] = field(default_factory=list)
    closed_s: float | None = None

    @property
    def root(self) -> Fault:
        return self.faults[0]

    @property
    def title(self) -> str:
        return self.root.cause or self.root.finding.seen

    def about(self) -> set[str]:
        """What its causes and its root are about."""
        names = {name for cause in self.causes for name in cause.about}
        return names | {*self.root.finding.processes, *self.root.finding.nodes}


class Grouping:
    """Puts each fault that is confirmed into an incident; numbers begin with `first`."""

    def __init__(self, first: int = 1) -> None:
        self._next = first
        self.incidents: list[Incident] = []

    def join(self, fault: Fault, cause: Cause | None, story: Story) -> tuple[Incident, bool]:
        """(its incident, whether that is new); `fault` gets the number, and what it follows."""
        for incident in reversed(self._recent(fault)):
            if incident.root is not fault and _belongs(fault, cause, incident, story):
                self._add(incident, fault, cause)
                return incident, False
        incident = Incident(number=self._next, opened_s=fault.life.first_s, faults=[fault])
        self._next += 1
        self.incidents.append(incident)
        self._forget_some()
        fault.incident, fault.follows = incident.number, None
        if cause is not None:
            incident.causes.append(cause)
        return incident, True

    def revise(self, fault: Fault, cause: Cause, story: Story) -> tuple[Incident, bool]:
        """Join anew with a better cause, unless others have followed it into its incident."""
        old = self.of(fault.incident)
        if old is not None and old.root is fault and len(old.faults) == 1:
            for incident in reversed(self._recent(fault)):
                if incident is not old and _belongs(fault, cause, incident, story):
                    self.incidents.remove(old)
                    self._add(incident, fault, cause)
                    return incident, False
        if old is None:
            return self.join(fault, cause, story)
        if cause.key not in [one.key for one in old.causes]:
            old.causes.insert(0 if old.root is fault else len(old.causes), cause)
        return old, False

    def _forget_some(self) -> None:
        over = [one for one in self.incidents if one.closed_s is not None]
        for incident in over[: max(0, len(self.incidents) - MOST_INCIDENTS)]:
            self.incidents.remove(incident)

    def _recent(self, fault: Fault) -> list[Incident]:
        """Those that were open when it was first seen, or a moment before."""
        first_s = fault.life.first_s
        return [
            one
            for one in self.incidents
            if one.closed_s is None or first_s - one.closed_s < TOGETHER_S
        ]

    def _add(self, incident: Incident, fault: Fault, cause: Cause | None) -> None:
        if fault not in incident.faults:
            incident.faults.append(fault)
        if fault.origin.kind in LEADING and incident.root.origin.kind not in LEADING:
            incident.faults.remove(fault)
            incident.faults.insert(0, fault)
        incident.closed_s = None
        for one in incident.faults:
            one.incident, one.follows = incident.number, incident.root.id
        incident.root.follows = None
        if cause is None or (cause.is_weak and fault is not incident.root):
            return  # what it follows from is the cause of the incident
        if cause.key not in [one.key for one in incident.causes]:
            incident.causes.append(cause)

    def closed(self, now_s: float) -> Iterable[Incident]:
        """The incidents that are over since the last call: all their faults are healed."""
        for incident in self.incidents:
            if incident.closed_s is None and not any(f.is_active for f in incident.faults):
                incident.closed_s = now_s
                yield incident

    def of(self, number: int | None) -> Incident | None:
        return next((one for one in self.incidents if one.number == number), None)


def _belongs(fault: Fault, cause: Cause | None, incident: Incident, story: Story) -> bool:
    """Whether they have a cause in common, or the fault is about what depends on the root."""
    known = incident.causes
    if cause is not None and cause.key in [one.key for one in known]:
        return True
    if any(MACHINE in one.about and one.rule == "clock step" for one in known):
        return cause is None or cause.is_weak
    # A death does not follow from what was wrong with the process before.
    derived = {name for one in known if one.rule in DERIVED for name in one.about}
    if cause is not None and cause.rule in DERIVED and cause.about & derived:
        return True
    is_open = cause is None or cause.is_weak
    return is_open and _is_in_time(fault, incident) and _depends(fault, incident, story)


def _is_in_time(fault: Fault, incident: Incident) -> bool:
    """Whether it began soon enough to be due to the incident."""
    if LASTING & {cause.rule for cause in incident.causes}:
        return True
    return fault.life.first_s - incident.root.life.first_s <= FOLLOWS_S


def _depends(fault: Fault, incident: Incident, story: Story) -> bool:
    """Whether it is about the processes of the incident, or about those that hear from them."""
    about = incident.about()
    mine = {*fault.finding.processes, *fault.finding.nodes}
    if mine & about:
        return True
    topics = story.published_by(about) | {n for n in about if n.startswith("/")}
    topics |= set(incident.root.finding.topics)
    if set(fault.finding.topics) & topics:
        return True
    hearing = story.subscribers(topics)
    return bool(hearing & mine) or bool(set(story.processes_of(hearing)) & mine)
