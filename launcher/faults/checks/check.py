"""What all checks have in common."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace

from launcher.base.text import did_you_mean, several
from launcher.faults.model.fault import FaultFinding, FaultOrigin
from launcher.faults.model.fault_life import Debounce
from launcher.faults.watcher.story import Story
from launcher.smoke.expect.expectation import Expectation
from launcher.smoke.expect.expectation_fields import Confirmation
from launcher.smoke.observe.facts import label_of, matches

GRACE_S = 15.0  # of a start, where the expectation names no time: discovery, and slow programs
SETTLE_S = 5.0  # after a user has started, stopped or restarted a process


@dataclass(frozen=True, slots=True)
class Found:
    """That a fault is seen now; `finding` None: it is not."""

    origin: FaultOrigin
    finding: FaultFinding | None


class Check:
    """Looks again and again; `debounce` is of the faults that it finds, `names` are theirs.

    A name that ends with `*` is for all that begin like this.
    What has held once counts from then on; before, only when its time has passed.
    """

    debounce = Debounce()
    names: tuple[str, ...] = ()

    def look(self, story: Story, known: Collection[str] = ()) -> Iterator[Found]:
        """Each fault that it decides on now; `known` are the ids of those that are not healed."""
        raise NotImplementedError


def origin(kind: str, about: str, expected: str) -> FaultOrigin:
    """Of a fault of every watched run, about one of several subjects."""
    return FaultOrigin(fault=f"{kind}: {about}", expectation=kind, kind=kind, expected=expected)


class SubjectCheck(Check):
    """A fault for each subject, with the id `KIND: SUBJECT`; one that is not found is not there.

    What it has found before is with the faults and not here: subjects come and go for days, and
    the watcher may be a new one.
    """

    kind = expected = ""

    def find(self, story: Story) -> Mapping[str, FaultFinding] | None:
        """What is wrong now, by subject; None if that is not known."""
        raise NotImplementedError

    def look(self, story: Story, known: Collection[str] = ()) -> Iterator[Found]:
        found = self.find(story)
        if found is None:
            return
        before = {one for one in known if one.startswith(f"{self.kind}: ")}
        subjects = found.keys() | {one.removeprefix(f"{self.kind}: ") for one in before}
        for subject in sorted(subjects):
            yield Found(origin(self.kind, subject, self.expected), found.get(subject))


class ExpectationCheck(Check):
    """The check of one expectation, with one fault."""

    def __init__(self, expectation: Expectation, expected: str) -> None:
        self.expectation = expectation
        self.origin = FaultOrigin(
            fault=expectation.name,
            expectation=expectation.name,
            kind=expectation.kind,
            expected=expected,
            place=str(expectation.origin),
        )
        self.debounce = debounce_of(expectation, self.debounce)
        self.names = (expectation.name,)
        self.must_have_held = False  # before it counts
        self._has_held = False

    @property
    def grace_s(self) -> float:
        """How long it may take from the start of the watch until it holds."""
        within = self.expectation.within
        return GRACE_S if within is None else max(within.high, GRACE_S)

    def look(self, story: Story, known: Collection[str] = ()) -> Iterator[Found]:
        is_known, finding = self.judge(story)
        if not is_known:
            return
        if finding is None:
            self._has_held = True
        elif not self._has_held and (self.must_have_held or story.now_s < self.grace_s):
            return
        elif finding.certain and self.expectation.get("confirm") is not None:
            finding = replace(finding, certain=False)
        yield Found(self.origin, finding)

    def judge(self, story: Story) -> tuple[bool, FaultFinding | None]:
        """(whether that is known now, what is wrong)."""
        raise NotImplementedError


def absence(pattern: str, story: Story) -> FaultFinding | None:
    """That no process of the run has such a name, as soon as there are any."""
    names = [str(row["name"]) for row in story.rows]
    is_there = any(matches(pattern, row["name"], tuple(row["node_names"])) for row in story.rows)
    if is_there or not names:
        return None
    hint = did_you_mean(pattern, [label_of(name) for name in names])
    return FaultFinding(
        seen=f"no process is named {pattern}; {hint or f'there are: {several(names)}'}"
    )


def debounce_of(expectation: Expectation, usual: Debounce) -> Debounce:
    """As its entries `confirm` and `heal` say, or as is usual."""
    confirm: Confirmation | None = expectation.get("confirm")
    heal_s = expectation.get("heal")
    if confirm is None:
        return usual if heal_s is None else replace(usual, heal_s=heal_s)
    for_s = usual.confirm_s if confirm.for_s is None else confirm.for_s
    heal_s = usual.heal_s if heal_s is None else heal_s
    return Debounce(confirm_s=for_s, times=confirm.times, heal_s=heal_s)
