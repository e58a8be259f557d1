"""The time that all drawings of an incident show, and how times are written."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass

from launcher.faults.incident.document import IncidentDocument

BEFORE_S, AFTER_S = 120.0, 60.0  # at most, around the incident
WIDTH = 1000.0  # of drawings, in their units
MINUS = "\u2212"  # as wide as a plus
_STEPS = (1, 2, 5, 10, 15, 30)


@dataclass(frozen=True, slots=True)
class TimeSpan:
    """From `start_s` to `end_s`; `zero_s` is when the incident opened."""

    start_s: float
    end_s: float
    zero_s: float

    @property
    def length_s(self) -> float:
        return self.end_s - self.start_s

    def holds(self, at_s: float) -> bool:
        return self.start_s <= at_s <= self.end_s

    def x(self, at_s: float) -> float:
        """The place of a time, from 0 to WIDTH; of times outside, at the edge."""
        part = (at_s - self.start_s) / self.length_s
        return round(min(1.0, max(0.0, part)) * WIDTH, 2)

    def percent(self, at_s: float) -> str:
        return f"{self.x(at_s) / WIDTH * 100:.2f}%"

    def ticks(self, most: int = 6) -> list[float]:
        """Round times before and after the opening."""
        step = _step(self.length_s / most)
        first = math.ceil((self.start_s - self.zero_s) / step)
        last = math.floor((self.end_s - self.zero_s) / step)
        return [self.zero_s + step * number for number in range(first, last + 1)]


def span_of(incident: IncidentDocument) -> TimeSpan:
    """All that is known around the incident, but not what was long before or after."""
    opened_s = incident.opened_s
    until_s = max([opened_s, *(one for one in _ends(incident) if one is not None)])
    times = [*_times(incident), opened_s]
    start_s = max(min(times), opened_s - BEFORE_S)
    end_s = min(max(times), until_s + AFTER_S)
    margin_s = max((end_s - start_s) * 0.01, 0.25)
    return TimeSpan(start_s - margin_s, max(end_s, until_s) + margin_s, opened_s)


def _ends(incident: IncidentDocument) -> Iterator[float | None]:
    yield incident.closed_s
    for fault in incident.faults:
        yield fault.last_s
        yield fault.healed_s


def _times(incident: IncidentDocument) -> Iterator[float]:
    for fault in incident.faults:
        yield from (
            one for one in (fault.first_s, fault.confirmed_s, fault.last_s, fault.healed_s) if one
        )
    for topic in incident.topics.values():
        yield from topic.arrivals
    for samples in incident.processes.values():
        yield from (row[0] for row in samples)
    yield from (row[0] for row in incident.machine)
    yield from (entry.wall_s for entry in incident.events)
    yield from (line.wall_s for line in incident.lines if line.wall_s)


def _step(least_s: float) -> float:
    if least_s >= 60:
        return float(60 * _round_up(least_s / 60))
    power = 10.0 ** math.floor(math.log10(max(least_s, 1e-3)))
    return next(
        (one * scale for scale in (power, power * 10) for one in _STEPS if one * scale >= least_s),
        60.0,
    )


def _round_up(minutes: float) -> int:
    return next(one for one in (1, 2, 5, 10, 20, 30, 60, 10**9) if one >= minutes or one == 10**9)


# ---- texts


def date(at_s: float) -> str:
    """`2026-11-30 16:07:25.121 +0100`, in the time zone of who writes the page."""
    local = time.localtime(at_s)
    stamp = time.strftime("%Y-%m-%d %H:%M:%S", local)
    return f"{stamp}.{int(at_s * 1000) % 1000:03} {time.strftime('%z', local)}"


def clock(at_s: float) -> str:
    """`16:07:25.121`."""
    return f"{time.strftime('%H:%M:%S', time.localtime(at_s))}.{int(at_s * 1000) % 1000:03}"


def offset(at_s: float, zero_s: float) -> str:
    """`+1.204 s`."""
    value = round(at_s - zero_s, 3)
    sign = MINUS if value < 0 else "+"
    return f"{sign}{abs(value):.3f} s" if abs(value) < 1000 else f"{sign}{abs(value):.0f} s"


def tick_text(at_s: float, zero_s: float) -> str:
    """`-20 s`, `0`, `+2 min`."""
    value = at_s - zero_s
    if abs(value) < 1e-9:
        return "0"
    sign = MINUS if value < 0 else "+"
    size = abs(value)
    return f"{sign}{size / 60:g} min" if size >= 120 else f"{sign}{round(size, 3):g} s"


def length(seconds: float) -> str:
    """`0.25 s`, `12.3 s`, `4 min 10 s`, `2 h 3 min`."""
    if seconds < 10:
        return f"{max(0.0, seconds):.2f} s"
    if seconds < 120:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 120:
        return f"{minutes} min {rest} s"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min"
