"""Expectation: one fact that a run has to show, and the verdict on it."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from launcher.smoke.expect.quantities import Span, seconds_text
from launcher.smoke.expect.source_location import Origin
from launcher.smoke.observe.facts import START, Facts

# What happened at the last moment of a window may take a while until we hear of it.
EVENT_LATENCY_S = 0.5


COMMAND_LINE = Origin(text="command line")


@dataclass(frozen=True, slots=True, kw_only=True)
class Expectation:
    """`kind` says what `subject` is and which `values` there are (`kinds.KINDS`).

    Times count from the step `after`; `within` None is until the system is stopped.
    """

    kind: str
    subject: Any
    name: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)
    within: Span | None = None
    after: str = START
    origin: Origin = COMMAND_LINE
    implicit: bool = False

    def get(self, name: str, default: Any = None) -> Any:
        """A value, or the default if it is not given."""
        return self.values.get(name, default)

    @property
    def key(self) -> str:
        """The question to the probe, for parameters and services."""
        return f"{self.kind} {self.name}"


class Outcome(enum.Enum):
    """Whether it holds; OPEN is possible only while the run goes on."""

    MET = "met"
    VIOLATED = "violated"
    OPEN = "open"


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """`expected` and `seen` are for people; `value` is what was measured, with its unit.

    `about` are the processes whose last lines may help; `guess` is what the facts support.
    """

    outcome: Outcome
    expected: str
    seen: str = ""
    at_s: float | None = None
    value: float | None = None
    unit: str = ""
    about: tuple[str, ...] = ()
    guess: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Period:
    """The window of an expectation in the time of the run; `closed` when all of it was seen."""

    start_s: float
    from_s: float
    to_s: float
    closed: bool

    def __contains__(self, at_s: float) -> bool:
        return self.from_s <= at_s <= self.to_s

    def is_too_early(self, at_s: float) -> bool:
        """Whether it is in the part before `5` of `5 to 8 s`."""
        return self.start_s <= at_s < self.from_s

    def since(self, at_s: float) -> str:
        """A time of the run as time since the window's beginning."""
        return seconds_text(max(0.0, at_s - self.start_s))


def period(expectation: Expectation, facts: Facts) -> Period | None:
    """When the expectation looks; None if its step has not happened."""
    start_s = facts.steps.get(expectation.after)
    if start_s is None:
        return None
    within = expectation.within
    low, high = (0.0, float("inf")) if within is None else (within.low, within.high)
    to_s = start_s + high
    closed = facts.is_over or facts.now_s >= to_s + EVENT_LATENCY_S
    if within is None:
        to_s = facts.stop_s
    return Period(start_s=start_s, from_s=start_s + low, to_s=to_s, closed=closed)


def times_text(expectation: Expectation) -> str:
    """` within 8 s after 'kill'`, for sentences."""
    within = "" if expectation.within is None else f" within {window_text(expectation.within)}"
    return within + ("" if expectation.after == START else f" after '{expectation.after}'")


def window_text(span: Span) -> str:
    """`8 s` or `5 to 8 s`."""
    return f"{span.low:g} to {span.high:g} s" if span.low else f"{span.high:g} s"
