"""What a run is expected to show, and the verdict whether it did."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from launcher.base.document.quantities import NumberRange
from launcher.base.document.source_location import Origin

START, READY, STOP = "start", "ready", "stop"
ALWAYS = (START, READY, STOP)  # moments of every run
LAUNCHER = "launch"  # the name of the launcher itself among the processes
COMMAND_LINE = Origin(text="command line")


@dataclass(frozen=True, slots=True, kw_only=True)
class Expectation:
    """`kind` decides what `subject` is and which `values` there are (`expectation_kinds.KINDS`).

    Times count from the step `after`; `within` None: until the system is stopped. `implicit`: of
    every run.
    """

    kind: str
    subject: Any
    name: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)
    within: NumberRange | None = None
    after: str = START
    origin: Origin = COMMAND_LINE
    implicit: bool = False

    def get(self, name: str, default: object = None) -> Any:
        return self.values.get(name, default)

    @property
    def key(self) -> str:
        """Identifies its answers from the probe (parameters and services)."""
        return f"{self.kind} {self.name}"


class Decision(enum.Enum):
    """OPEN: not decided yet; it occurs only during the run."""

    MET = "met"
    VIOLATED = "violated"
    OPEN = "open"


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """`expected`, `seen` and `guess` (a probable cause) are text; `value` is a measured number.

    `about`: processes whose last lines are shown with a failure.
    """

    outcome: Decision
    expected: str
    seen: str = ""
    at_s: float | None = None
    value: float | None = None
    unit: str = ""
    about: tuple[str, ...] = ()
    guess: str | None = None
