"""Numbers over time, reduced to what a drawing can show. No I/O."""

from __future__ import annotations

import bisect
import math
import re
from collections.abc import Iterable, Sequence

from launcher.faults.incident.parts.span import TimeSpan

COLUMNS = 250  # of a curve
MARKS = 500  # of a row of marks

Curve = list[tuple[float, float]]
_HERTZ = re.compile(
    r"([\d.]+)(?:\s*(?:to|-|\.\.)\s*([\d.]+))?\s*(?:Hz\b|/s\b|per second)(?:\s*±\s*([\d.]+)\s*%)?"
)
_PERIOD = re.compile(r"every\s+([\d.]+)\s*(ms|s)\b")
_SECONDS = re.compile(r"([\d.]+)\s*(ms|s)\b")


def rates(arrivals: Sequence[float], span: TimeSpan, until_s: float = math.inf) -> Curve:
    """The rate in Hz in each column: of its messages, or of the interval that covers it.

    After the last message the interval is as long as the silence, so the curve falls. Nothing is
    known before the first one, and after `until_s`.
    """
    if not arrivals:
        return []
    width_s = span.length_s / COLUMNS
    curve: Curve = []
    for column in range(COLUMNS):
        start_s = span.start_s + column * width_s
        end_s = start_s + width_s
        first, last = bisect.bisect_left(arrivals, start_s), bisect.bisect_left(arrivals, end_s)
        if last == 0 or (last == len(arrivals) and start_s > until_s):
            continue
        if last - first >= 3:
            rate = (last - first) / width_s
        else:
            rate = _rate_of_gap(arrivals, last, end_s)
        curve.append((start_s + width_s / 2, rate))
    return curve


def _rate_of_gap(arrivals: Sequence[float], after: int, now_s: float) -> float:
    """Of the interval that ends with `arrivals[after]`; behind the last, at most the one before."""
    before_s = arrivals[after - 1]
    if after < len(arrivals):
        gap_s = arrivals[after] - before_s
    else:
        usual_s = before_s - arrivals[after - 2] if after > 1 else math.inf
        gap_s = max(now_s - before_s, usual_s)
    return 0.0 if math.isinf(gap_s) else 1 / max(gap_s, 1e-6)


def longest_gap(arrivals: Sequence[float], span: TimeSpan) -> tuple[float, float] | None:
    """(start, length) of the longest time without a message, its end included."""
    times = [one for one in arrivals if span.holds(one)]
    if not times:
        return None
    pairs = zip(times, [*times[1:], span.end_s], strict=True)
    start_s, end_s = max(pairs, key=lambda pair: pair[1] - pair[0])
    return start_s, end_s - start_s


def highest(points: Iterable[tuple[float, float]], span: TimeSpan) -> Curve:
    """The highest value of each column that has one."""
    found: dict[int, tuple[float, float]] = {}
    for at_s, value in points:
        if span.holds(at_s) and not math.isnan(value):
            column = int((at_s - span.start_s) / span.length_s * COLUMNS)
            if column not in found or value > found[column][1]:
                found[column] = (at_s, value)
    return [found[column] for column in sorted(found)]


def thinned(times: Sequence[float], span: TimeSpan) -> list[float]:
    """At most one time in each of MARKS columns."""
    found: dict[int, float] = {}
    for at_s in times:
        if span.holds(at_s):
            found.setdefault(int((at_s - span.start_s) / span.length_s * MARKS), at_s)
    return list(found.values())


def expected_hz(text: str | None) -> list[float]:
    """The limits that a text such as `at least 5 Hz`, `10 Hz ± 20 %` or `every 0.5 s` names."""
    if not text:
        return []
    found = _HERTZ.search(text)
    if found is not None:
        rates = [one for one in map(_number, found.groups()[:2]) if one is not None]
        part = (_number(found[3]) or 0.0) / 100
        return [rate * one for rate in rates for one in ((1 - part, 1 + part) if part else (1,))]
    period = _PERIOD.search(text)
    seconds = None if period is None else _number(period[1])
    if period is None or not seconds:
        return []
    return [1 / (seconds / 1000 if period[2] == "ms" else seconds)]


def expected_seconds(text: str | None) -> float | None:
    """The time that a text such as `below 50 ms` names."""
    found = _SECONDS.search(text or "")
    seconds = None if found is None else _number(found[1])
    if found is None or seconds is None:
        return None
    return seconds / 1000 if found[2] == "ms" else seconds


def _number(text: str | None) -> float | None:
    try:
        return None if text is None else float(text)
    except ValueError:  # `1.2.3`
        return None


def nice_top(value: float) -> float:
    """The next round number above."""
    if value <= 0 or not math.isfinite(value):
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(power * one for one in (1, 1.5, 2, 3, 4, 5, 6, 8, 10, 20) if power * one >= value)
