"""Script: everything that a smoke run is to do and to see, from a file and from flags."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from launcher.smoke.expect.expectation import Expectation
from launcher.smoke.expect.expectation_kinds import BY_NAME
from launcher.smoke.expect.source_location import Origin
from launcher.smoke.expect.steps import Chaos, Step
from launcher.smoke.observe.facts import READY, START, STOP

SHORTEST_S = 5.0  # a run without any times still looks for a while
DEFAULT_READY_S = 10.0
STEP_ROOM_S = 1.0  # a step needs a moment
PRESENCE = ("node", "topic", "qos")
OF_EVERY_RUN = Origin(text="expected of every run")
ALWAYS = (START, READY, STOP)  # moments that every run has


@dataclass(frozen=True, slots=True, kw_only=True)
class Script:
    """`for_s` and `ready_within_s` are None where nobody said; `path` is the file, if there is one.

    `options` are words for the launcher, such as `--restart=robot_*=always`.
    """

    expectations: tuple[Expectation, ...] = ()
    steps: tuple[Step, ...] = ()
    chaos: Chaos | None = None
    for_s: float | None = None
    ready_within_s: float | None = None
    arguments: Mapping[str, str] = field(default_factory=dict)
    options: tuple[str, ...] = ()
    path: str | None = None

    def known_steps(self) -> tuple[str, ...]:
        """What `after` may name."""
        moments = (moment for step in self.steps for moment in step.moments)
        return (*ALWAYS, *moments)

    def presence(self) -> tuple[Expectation, ...]:
        """What has to be there before the system is ready."""
        return tuple(
            e
            for e in self.expectations
            if e.kind in PRESENCE and e.after == START and not e.get("absent")
        )

    def ready_limit_s(self) -> float:
        """How long the system may take to be ready."""
        if self.ready_within_s is not None:
            return self.ready_within_s
        times = [e.within.high for e in self.presence() if e.within is not None]
        return max(times, default=DEFAULT_READY_S)

    def run_time_s(self) -> float:
        """How long the system is watched: as asked, else until the last time that is named."""
        if self.for_s is not None:
            return self.for_s
        begins = self._step_times()
        ends = [
            begins.get(e.after, 0.0) + e.within.high
            for e in self.expectations
            if e.within is not None and e.after != STOP
        ]
        steps = [begins[step.name] + STEP_ROOM_S for step in self.steps]
        return max([SHORTEST_S, *ends, *steps])

    def _step_times(self) -> dict[str, float]:
        """When each step is expected; one that waits for a log line, right away."""
        times = {START: 0.0, READY: self.ready_limit_s()}
        for step in self.steps:
            room_s = float(step.command.words.get("time_s", 0.0))
            at_s = times.get(step.after, 0.0) + step.delay_s
            times |= dict.fromkeys(step.moments, at_s + room_s)
        return times

    def earliest_s(self) -> dict[str, float]:
        """Before when each moment that `after` may name cannot come."""
        times = dict.fromkeys(ALWAYS, 0.0)
        for step in self.steps:
            at_s = times.get(step.after, 0.0) + step.delay_s
            times |= dict.fromkeys(step.moments, at_s)
            if step.over in times:
                times[step.over] = at_s + step.command.words["time_s"]
        return times

    def needs_ros(self) -> bool:
        """Whether a probe is needed to judge or do any of it."""
        return any(BY_NAME[e.kind].needs_ros for e in self.expectations) or any(
            step.command.needs_ros for step in self.steps
        )

    def announced(self) -> tuple[str, ...]:
        """Patterns of processes whose death an expectation announces."""
        return tuple(
            e.subject
            for e in self.expectations
            if e.kind == "process" and (e.get("exits") is not None or e.get("alive") is False)
        )

    def completed(self) -> Script:
        """With unlike names, and with what every run expects by itself."""
        deaths = Expectation(
            kind="no_deaths",
            subject="*",
            name="no process dies unasked",
            values={"but": self.announced()},
            implicit=True,
            origin=OF_EVERY_RUN,
        )
        given = [e for e in self.expectations if e.kind != "no_deaths"]
        return replace(self, expectations=tuple(_with_names([*given, deaths])))


def default_name(kind: str, subject: object) -> str:
    """What an expectation is called that has no name."""
    if isinstance(subject, tuple):
        subject = " > ".join(getattr(one, "pattern", str(one)) for one in subject)
    text = getattr(subject, "pattern", subject)
    shown = f"{text:g} s" if isinstance(text, float) else str(text)
    return f"{kind.replace('_', ' ')} {shown}"


def _with_names(expectations: Iterable[Expectation]) -> Iterable[Expectation]:
    counts: dict[str, int] = {}
    for expectation in expectations:
        name = expectation.name or default_name(expectation.kind, expectation.subject)
        counts[name] = counts.get(name, 0) + 1
        unlike = name if counts[name] == 1 else f"{name} ({counts[name]})"
        yield replace(expectation, name=unlike)
