"""Several runs of one system, and what they have in common."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from launcher.base.document.quantities import seconds_text
from launcher.smoke.record.name_patterns import Names
from launcher.smoke.record.observed_run import ObservedRun

# A busy machine is several times slower than the one of the recording.
LEAST_WITHIN_S = 20.0
TIMES_SLOWER, MORE_S = 3.0, 10.0
_STEPS_S = (5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 90.0)
_MINUTE_S = 60.0


@dataclass(frozen=True, slots=True)
class RecordedExpectation:
    """An expectation as it is written, and what was seen. Without `values`: why there is none."""

    values: Mapping[str, Any]
    seen: str


def note(text: str) -> RecordedExpectation:
    return RecordedExpectation({}, text)


def rounded_up_s(time_s: float) -> float:
    """A time that a person would write."""
    above = (step for step in _STEPS_S if step >= time_s)
    return next(above, _MINUTE_S * math.ceil(time_s / _MINUTE_S))


def limit_s(times_s: Iterable[float]) -> float:
    """A time limit for what was seen at these times."""
    return rounded_up_s(max(LEAST_WITHIN_S, TIMES_SLOWER * max(times_s) + MORE_S))


def within(times_s: Iterable[float]) -> str:
    return f"{limit_s(times_s):g} s"


def after_text(times_s: Sequence[float]) -> str:
    """`seen after 1.2 and 1.4 s`."""
    texts = dict.fromkeys(seconds_text(time_s).removesuffix(" s") for time_s in times_s)
    return f"seen after {' and '.join(texts)} s"


class Runs(tuple[ObservedRun, ...]):
    """The runs, and the names of each kind that they have in common."""

    def _names(self, of: Callable[[ObservedRun], Iterable[str]]) -> Names:
        return Names([of(run) for run in self], [run.pids for run in self])

    @functools.cached_property
    def labels(self) -> Names:
        return self._names(lambda run: run.processes)

    @functools.cached_property
    def nodes(self) -> Names:
        return self._names(lambda run: run.nodes)

    @functools.cached_property
    def topics(self) -> Names:
        return self._names(lambda run: run.topics)

    @functools.cached_property
    def services(self) -> Names:
        return self._names(lambda run: run.services)
