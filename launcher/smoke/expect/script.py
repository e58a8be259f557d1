"""Everything that a smoke run does and expects, from a file and from options."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from launcher.base.document.source_location import Origin
from launcher.smoke.expect.expectation import ALWAYS, READY, START, STOP, Expectation
from launcher.smoke.expect.expectation_kinds import BY_NAME
from launcher.smoke.expect.likeness import Likeness
from launcher.smoke.expect.steps import Chaos, Step

MIN_RUN_S = 5.0  # of a run without any times
DEFAULT_READY_S = 10.0
GROWTH_RUN_S = 20.0  # of a run in which the growth of memory is measured after the start-up
STEP_ROOM_S = 1.0  # what a step may take
PRESENCE = ("node", "topic", "qos")
OF_EVERY_RUN = Origin(text="expected of every run")


@dataclass(frozen=True, slots=True, kw_only=True)
class Script:
    """`for_s` and `ready_within_s` are None if not given; `path` is the file, if there is one.

    `options` are for the launcher, such as `--restart=robot_*=always`.
    """

    expectations: tuple[Expectation, ...] = ()
    steps: tuple[Step, ...] = ()
    chaos: Chaos | None = None
    for_s: float | None = None
    ready_within_s: float | None = None
    arguments: Mapping[str, str] = field(default_factory=dict)
    options: tuple[str, ...] = ()
    path: str | None = None

    def moments(self) -> list[str]:
        """What `after` may name, besides the moments of every run."""
        return [moment for step in self.steps for moment in step.moments]

    def presence(self) -> tuple[Expectation, ...]:
        """Expectations that have to be met before the system is ready."""
        return tuple(
            e
            for e in self.expectations
            if e.kind in PRESENCE and e.after == START and not e.get("absent")
        )

    def ready_limit_s(self) -> float:
        if self.ready_within_s is not None:
            return self.ready_within_s
        times = [e.within.high for e in self.presence() if e.within is not None]
        return max(times, default=DEFAULT_READY_S)

    def waits_beyond(self) -> bool:
        """Whether the system may become ready after the time of one of its expectations."""
        limit_s = self.ready_limit_s()
        return any(e.within is not None and e.within.high < limit_s for e in self.presence())

    def run_time_s(self) -> float:
        """How long the system is observed: as given, else until the last time limit."""
        if self.for_s is not None:
            return self.for_s
        begins = self._step_times()
        ends = [
            begins.get(e.after, 0.0) + e.within.high
            for e in self.expectations
            if e.within is not None and e.after != STOP
        ]
        steps = [begins[step.name] + STEP_ROOM_S for step in self.steps]
        return max(
            [self.least_run_s(), *ends, *steps, *(one.duration_s for one in self.likenesses())]
        )

    def least_run_s(self) -> float:
        """How long the system is observed whatever is decided, if no duration is given."""
        measures = any(e.get("growth") is not None and e.within is None for e in self.expectations)
        return GROWTH_RUN_S if measures else MIN_RUN_S

    def likenesses(self) -> Iterator[Likeness]:
        """The bags that the run is expected to be like."""
        for expectation in self.expectations:
            if isinstance(expectation.subject, Likeness):
                yield expectation.subject

    def recorded_topics(self) -> tuple[str, ...]:
        """Those of all these bags; BagError."""
        return tuple(dict.fromkeys(name for one in self.likenesses() for name in one.reference))

    def _step_times(self) -> dict[str, float]:
        """The latest time of each step; a log line to wait for is assumed to come at once."""
        times = {START: 0.0, READY: self.ready_limit_s()}
        for step in self.steps:
            at_s = times.get(step.after, 0.0) + step.delay_s
            times |= dict.fromkeys(step.moments, at_s + step.pause_s)
        return times

    def earliest_s(self) -> dict[str, float]:
        """The earliest possible time of each moment that `after` may name."""
        times = dict.fromkeys(ALWAYS, 0.0)
        for step in self.steps:
            at_s = times.get(step.after, 0.0) + step.delay_s
            times |= dict.fromkeys(step.moments, at_s)
            if step.over in times:
                times[step.over] = at_s + step.pause_s
        return times

    def needs_ros(self) -> bool:
        return any(BY_NAME[e.kind].needs_ros for e in self.expectations) or any(
            step.command.needs_ros for step in self.steps
        )

    def expected_exits(self) -> tuple[str, ...]:
        """Patterns of processes that are expected to exit."""
        return tuple(
            e.subject
            for e in self.expectations
            if e.kind == "process" and (e.get("exits") is not None or e.get("alive") is False)
        )

    def with_expectations(self, expectations: Iterable[Expectation]) -> Script:
        """The same with these in place of the expectations that it has."""
        return replace(self, expectations=tuple(expectations))

    def completed(self) -> Script:
        """With unique names, and with the expectation of every run."""
        deaths = Expectation(
            kind="no_deaths",
            subject="*",
            name="no unexpected exits",
            values={"but": self.expected_exits()},
            implicit=True,
            origin=OF_EVERY_RUN,
        )
        given = [e for e in self.expectations if e.kind != "no_deaths"]
        return replace(self, expectations=tuple(_with_names([*given, deaths])))


def _with_names(expectations: Iterable[Expectation]) -> Iterable[Expectation]:
    counts: dict[str, int] = {}
    for expectation in expectations:
        name = expectation.name or _default_name(expectation.kind, expectation.subject)
        counts[name] = counts.get(name, 0) + 1
        unique = name if counts[name] == 1 else f"{name} ({counts[name]})"
        yield replace(expectation, name=unique)


def _default_name(kind: str, subject: object) -> str:
    if isinstance(subject, tuple):
        subject = " > ".join(getattr(one, "pattern", str(one)) for one in subject)
    text = getattr(subject, "pattern", subject)
    shown = f"{text:g} s" if isinstance(text, float) else str(text)
    return f"{kind.replace('_', ' ')} {shown}"
