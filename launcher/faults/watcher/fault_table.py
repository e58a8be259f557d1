"""The faults of a run: what checks find, with causes and incidents."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from launcher.faults.causes.cause import OF_TIME, Cause
from launcher.faults.causes.grouping import Grouping, Incident
from launcher.faults.causes.rules import cause_of
from launcher.faults.checks.check import GRACE_S, SETTLE_S, Check, Found
from launcher.faults.model.fault import Fault
from launcher.faults.model.fault_life import FaultChange, FaultState
from launcher.faults.watcher.story import Story

UNDECIDED_S = 0.7  # what explains a fault may be seen so long after it is suspected,
ELSEWHERE_S = (
    1.7  # and on another host, which sends something each second, so long after it is confirmed
)
UPSTREAM_S = 3.0  # a fault of what its processes listen to may be about to be confirmed
REVISED_S = 3.0  # as long a better cause replaces one that is weak
UPDATE_S = 1.0  # so often at most, what was seen is reported anew
REFRESH_S = 10.0  # so often at least, that it is still seen
MOST_FAULTS = 1000  # ids that are remembered: those that healed long ago are forgotten first

FORGOTTEN = "forgotten"  # the change of one that nobody keeps any more
Report = Callable[[Fault, str], object]


class FaultTable:
    """`report` gets each fault that has changed, with the change."""

    def __init__(self, report: Report, first_incident: int = 1) -> None:
        self.faults: dict[str, Fault] = {}
        self._report = report
        self._grouping = Grouping(first_incident)
        self._undecided: dict[str, float] = {}  # confirmed, and not reported yet: since when
        self._weak: dict[str, float] = {}  # with a weak cause, or none: until when it is revised
        self._reported: dict[str, tuple[str, float]] = {}
        self.mutes: dict[str, dict[str, Any]] = {}  # of faults that were not seen yet

    def resume(self, documents: Iterable[Mapping[str, Any]], of_wall: Callable[..., float]) -> None:
        """Go on with the faults that an earlier watcher of this run has reported."""
        for document in documents:
            fault = self.faults[document["fault"]] = Fault.resumed(document, of_wall)
            if fault.muted is not None:
                self.mutes[fault.id] = fault.muted

    # ---- what checks have found

    def look(self, checks: Iterable[Check], story: Story) -> None:
        """Have them look, and take what they find."""
        known = [f.id for f in self.faults.values() if f.life.state is not FaultState.HEALED]
        for check in checks:
            for found in check.look(story, known):
                self.take(check, found, story)

    def take(self, check: Check, found: Found, story: Story) -> None:
        """That a fault is seen now, or that it is not."""
        fault, finding = self.faults.get(found.origin.fault), found.finding
        if finding is None:
            if fault is not None:
                self._held(fault, story.now_s)
            return
        is_open = not finding.settles or (fault is not None and fault.is_active)
        if not is_open and any(_is_settling(name, story) for name in _concerned(found, story)):
            if fault is not None:
                self._held(fault, story.now_s)
            return
        if fault is None:
            fault = self.faults[found.origin.fault] = Fault.of(
                found.origin, check.debounce, finding
            )
            fault.muted = self.mutes.get(fault.id)
            self._forget_some()
        elif fault.life.state is FaultState.HEALED:
            fault.acknowledged = None  # what is taken care of was another time
        fault.life.debounce = check.debounce
        fault.finding = finding
        fault.lines = story.last_lines(finding.processes)
        change = fault.life.violated(
            story.now_s, since_s=finding.since_s, times=finding.times, certain=finding.certain
        )
        match change:
            case FaultChange.SUSPECTED:
                self._report(fault, change.value)
            case FaultChange.CONFIRMED:
                self._undecided[fault.id] = story.now_s
            case None if fault.is_active:
                self._update(fault, story.now_s)

    def _held(self, fault: Fault, now_s: float) -> None:
        change = fault.life.held(now_s)
        if change is None:
            return
        if change is FaultChange.HEALED and fault.id in self._undecided:
            self._undecided[fault.id] = -UPSTREAM_S  # first that it was confirmed
            fault.life.healed_s = now_s
            return
        if change is FaultChange.DISMISSED and fault.life.count == 0:
            del self.faults[fault.id]
        self._report(fault, change.value)

    def _update(self, fault: Fault, now_s: float) -> None:
        """Report what is seen now, soon if it differs."""
        seen, at_s = self._reported.get(fault.id, ("", now_s))
        period_s = UPDATE_S if seen != fault.finding.seen else REFRESH_S
        if fault.id not in self._undecided and now_s - at_s >= period_s:
            self._note(fault, "updated", now_s)

    def _note(self, fault: Fault, change: str, now_s: float) -> None:
        self._reported[fault.id] = fault.finding.seen, now_s
        self._report(fault, change)

    def _forget_some(self) -> None:
        """Forget those that healed long ago; the launcher forgets what was never confirmed."""
        if len(self.faults) <= MOST_FAULTS:
            return
        healed = [f for f in self.faults.values() if f.life.state is FaultState.HEALED]
        for fault in sorted(healed, key=lambda f: f.life.last_s)[: MOST_FAULTS // 10]:
            del self.faults[fault.id]
            self._reported.pop(fault.id, None)
            self._report(fault, FORGOTTEN)

    # ---- causes and incidents

    def decide(self, story: Story) -> list[tuple[Incident, bool]]:
        """Explain what was confirmed; the incidents that have changed, and whether they are new."""
        changed = [self._confirm(fault, cause, story) for fault, cause in self._decided(story)]
        for name, until_s in tuple(self._weak.items()):
            fault = self.faults.get(name)
            if fault is None or story.now_s > until_s:
                del self._weak[name]
            elif (cause := cause_of(fault, story)) is not None and not cause.is_weak:
                del self._weak[name]
                changed.append(self._revise(fault, cause, story))
        return changed

    def _decided(self, story: Story) -> Iterator[tuple[Fault, Cause | None]]:
        """Those whose cause is known, or that have waited for one; roots come first."""
        found = []
        for name, since_s in tuple(self._undecided.items()):
            fault = self.faults.get(name)
            if fault is None:
                del self._undecided[name]
                continue
            cause = cause_of(fault, story)
            is_clear = cause is not None and not cause.is_weak
            if is_clear or self._is_due(fault, since_s, story):
                del self._undecided[name]
                found.append((fault, cause))
        return iter(_from_upstream(found, story))

    def _is_due(self, fault: Fault, confirmed_s: float, story: Story) -> bool:
        """Whether nothing that explains it is to be expected any more."""
        waited_s = story.now_s - confirmed_s
        if waited_s >= UPSTREAM_S:
            return True
        if any(self._is_pending(one) for one in self._upstream(fault, story)):
            return False
        if story.hosts_of(fault.finding.processes):
            return waited_s >= ELSEWHERE_S
        return story.now_s - fault.life.suspected_s >= UNDECIDED_S

    def _is_pending(self, fault: Fault) -> bool:
        return fault.life.state is FaultState.SUSPECTED or fault.id in self._undecided

    def _upstream(self, fault: Fault, story: Story) -> list[Fault]:
        """Other faults, of topics that the processes of this one listen to."""
        heard = story.heard_by(fault.finding.processes)
        return [
            one
            for one in self.faults.values()
            if one is not fault and heard & set(one.finding.topics)
        ]

    def _confirm(self, fault: Fault, cause: Cause | None, story: Story) -> tuple[Incident, bool]:
        _explain(fault, cause)
        incident, is_new = self._grouping.join(fault, cause, story)
        if cause is None or cause.is_weak:
            self._weak[fault.id] = story.now_s + REVISED_S
        self._note(fault, FaultChange.CONFIRMED.value, story.now_s)
        if incident.root is fault:  # for others that were there first, too
            for other in incident.faults[1:]:
                self._note(other, "updated", story.now_s)
        if not fault.is_active:
            self._report(fault, FaultChange.HEALED.value)
        return incident, is_new

    def _revise(self, fault: Fault, cause: Cause, story: Story) -> tuple[Incident, bool]:
        _explain(fault, cause)
        incident, is_new = self._grouping.revise(fault, cause, story)
        self._note(fault, "updated", story.now_s)
        return incident, is_new

    def closed(self, now_s: float) -> list[Incident]:
        """The incidents that are over since the last call."""
        return [*self._grouping.closed(now_s)]

    @property
    def incidents(self) -> list[Incident]:
        return self._grouping.incidents

    # ---- what users say

    def acknowledge(self, name: str, reason: str | None) -> Fault:
        """KeyError for one that is not known."""
        fault = self.faults[name]
        fault.acknowledged = {"wall_s": round(time.time(), 3), "reason": reason}
        return fault

    def mute(self, name: str, reason: str | None, until_s: float | None) -> Fault | None:
        """Until this time of the day, or for good; None for one that was not seen yet."""
        fault = self.faults.get(name)
        self.mutes[name] = {"reason": reason, "until_s": until_s}
        if fault is not None:
            fault.muted = self.mutes[name]
        return fault

    def unmute(self, name: str) -> Fault | None:
        """None for one that was not seen yet; KeyError if it is not muted either."""
        fault = self.faults.get(name)
        if fault is None:
            del self.mutes[name]
            return None
        fault.muted = None
        self.mutes.pop(name, None)
        return fault

    def end_mutes(self) -> None:
        """End those whose time has come."""
        now_s = time.time()
        for name, mute in tuple(self.mutes.items()):
            if mute["until_s"] is not None and mute["until_s"] <= now_s:
                del self.mutes[name]
                if name in self.faults and (fault := self.unmute(name)) is not None:
                    self._report(fault, "updated")


def _from_upstream(
    found: list[tuple[Fault, Cause | None]], story: Story
) -> list[tuple[Fault, Cause | None]]:
    """By time, and each behind those of topics that its processes listen to."""
    found.sort(key=lambda one: one[0].life.first_s)
    topics = {topic for fault, _ in found for topic in fault.finding.topics}
    heard = {
        fault.id: len(topics & (story.heard_by(fault.finding.processes) - {*fault.finding.topics}))
        for fault, _ in found
    }
    return sorted(found, key=lambda one: heard[one[0].id])


def _concerned(found: Found, story: Story) -> tuple[str, ...]:
    """The processes of a finding, and those that they hear from if it is about their messages."""
    assert found.finding is not None
    names = found.finding.processes
    return (*names, *story.feeders(names)) if found.origin.kind in OF_TIME else names


def _explain(fault: Fault, cause: Cause | None) -> None:
    fault.cause, fault.rule = (None, None) if cause is None else (cause.text, cause.rule)
    fault.is_certain = cause is not None and not cause.is_weak


def _is_settling(process: str, story: Story) -> bool:
    """Whether a user has just started or stopped it, or it was just started for the first time."""
    if story.was_asked(process, SETTLE_S):
        return True
    first_s = story.first_start_s(process)
    return first_s is not None and story.now_s - first_s < GRACE_S
