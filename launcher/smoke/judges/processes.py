"""Judges of processes: running, exited, restarted, and their resource usage."""

from __future__ import annotations

import statistics
from collections.abc import Iterator, Sequence
from typing import Any

from launcher.base.document.quantities import INFINITY, NumberRange
from launcher.base.model.run_event import RunEvent, exit_text
from launcher.base.model.run_events import Ended, Ready, Started
from launcher.base.text import several
from launcher.smoke.expect.expectation import Decision, Expectation, Verdict
from launcher.smoke.judges import explain
from launcher.smoke.judges.common import (
    Window,
    listed,
    times_text,
    with_window,
)
from launcher.smoke.judges.time_series import GROWTH_S, START_UP_S, growth_per_s
from launcher.smoke.observe.facts import Facts, ProcessEvent, UsageSample

_MB = 1024 * 1024
_MINUTE_S = 60.0


# ---- running, exited, restarted


def _process_text(expectation: Expectation) -> str:
    pattern = expectation.subject
    parts = []
    if expectation.get("exits") is not None:
        parts.append(f"ends with {exit_text(expectation.get('exits'))}")
    if expectation.get("restarts") is not None:
        parts.append(f"is restarted {expectation.get('restarts').text} times")
    if expectation.get("alive") is False:
        parts.append("does not run at the end")
    elif expectation.get("alive") or not parts:
        parts.append("runs at the end")
    return f"process {pattern} {' and '.join(parts)}{times_text(expectation)}"


@with_window(_process_text)
def process(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    names = facts.named(expectation.subject)
    if not names:
        seen = f"no such process; there are: {listed(facts.processes())}"
        return when.not_yet(seen=seen)
    verdicts = [v for name in names for v in _verdicts(expectation, facts, name, when)]
    return max(verdicts, key=lambda verdict: _RANK[verdict.outcome])


_RANK = {Decision.MET: 0, Decision.OPEN: 1, Decision.VIOLATED: 2}


def _verdicts(expectation: Expectation, facts: Facts, name: str, when: Window) -> Iterator[Verdict]:
    exits, restarts, alive = (expectation.get(key) for key in ("exits", "restarts", "alive"))
    if exits is not None:
        yield _exits(exits, facts, name, when)
    if restarts is not None:
        yield _restarts(restarts, facts, name, when)
    if alive is not None or (exits is None and restarts is None):
        yield _alive(facts, name, alive is not False, when)


def _exits(wanted: int, facts: Facts, name: str, when: Window) -> Verdict:
    ends = [e for e in facts.of(Ended, name) if e.at_s in when]
    for end in ends:
        if end.event.returncode == wanted:
            seen = f"{name} after {when.since(end.at_s)}"
            return when.met(seen=seen, at_s=end.at_s, value=end.at_s, unit="s")
    if ends:
        seen = f"{name} ended with {_end_text(ends[-1])} after {when.since(ends[-1].at_s)}"
    else:
        later = next((e for e in facts.of(Ended, name) if e.at_s > when.to_s), None)
        seen = f"{name} did not end"
        seen += f" in time, but after {when.since(later.at_s)}" if later else ""
    return when.not_yet(seen=seen, about=(name,))


def _end_text(end: ProcessEvent[Ended]) -> str:
    return exit_text(end.event.returncode)


def _restarts(span: NumberRange, facts: Facts, name: str, when: Window) -> Verdict:
    starts = [e for e in facts.of(Started, name) if e.at_s in when]
    first = next(facts.of(Started, name), None)
    count = sum(event is not first for event in starts)
    seen = f"{name}: {count} restarts"
    if when.is_enough(count, span):
        return when.met(seen=seen, value=count)
    make = when.violated if count > span.high else when.not_yet
    return make(seen=seen, value=count, about=(name,))


def _alive(facts: Facts, name: str, alive: bool, when: Window) -> Verdict:
    """At the end, when the system is stopped."""
    if not facts.is_over:
        return when.open()
    if facts.was_running(name, facts.stop_s) is alive:
        return when.met(seen=f"{name} {'ran' if alive else 'did not run'}")
    if not alive:
        return when.violated(seen=f"{name} still ran", about=(name,))
    last = facts.last_end(name)
    if last is None:
        return when.violated(seen=f"{name} could not be started", about=(name,))
    seen = f"{name} ended at {last.at_s:.1f} s of the run with {_end_text(last)}"
    return when.violated(seen=seen, at_s=last.at_s, about=(name,))


# ---- readiness


@with_window(lambda e: f"{e.subject} is ready{times_text(e)}")
def ready(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    """Each process that the pattern matches, for the first time."""
    names = facts.named(expectation.subject) or facts.unready(expectation.subject)
    if not names:
        guess = explain.unknown_process(expectation.subject, facts)
        return when.not_yet(seen="no such process was started", guess=guess)
    moments = {name: next(facts.of(Ready, name), None) for name in names}
    missing = [name for name, event in moments.items() if event is None or event.at_s > when.to_s]
    if missing:
        seen = several(_unready(name, moments[name], facts, when) for name in missing)
        return when.not_yet(seen=seen, about=(*missing,))
    at_s = max(event.at_s for event in moments.values() if event is not None)
    if when.is_too_early(at_s):
        return when.violated(seen=f"too early, after {when.since(at_s)}", at_s=at_s)
    return when.met(seen=f"after {when.since(at_s)}", at_s=at_s, value=at_s, unit="s")


def _unready(name: str, event: ProcessEvent[Ready] | None, facts: Facts, when: Window) -> str:
    """Why a process is not ready, or when it was."""
    if event is not None:
        return f"{name} was ready after {when.since(event.at_s)}"
    if name in facts.unready(name):
        start = next(reversed([*facts.of(Started, name)]), None)
        awaited = () if start is None else start.event.ready_when
        return f"{name} has no {', '.join(awaited)}" if awaited else f"{name} waits for others"
    end = facts.last_end(name)
    if end is not None:
        return f"{name} ended with {_end_text(end)}"
    return f"{name} has no 'ready_when' in a supervision file"


# ---- unexpected exits


@with_window(lambda e: "no process exits unexpectedly" + times_text(e))
def no_deaths(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    """`but`: patterns of processes that are expected to exit."""
    expected_exits = expectation.get("but", ())
    bad = [
        event
        for event in facts.events
        if event.process is not None
        and event.at_s in when
        and event.event.is_failure
        and event.process not in facts.ended_by_steps
        and not any(facts.is_named(event.process, pattern) for pattern in expected_exits)
    ]
    if not bad:
        return when.so_far(seen="none")
    first = bad[0]
    names = [event.process for event in bad if event.process]
    return when.violated(
        seen=several(_exit_line(event) for event in bad),
        at_s=first.at_s,
        about=tuple(dict.fromkeys(names)),
        guess=explain.last_exception(names[0], facts),
    )


def _exit_line(one: ProcessEvent[RunEvent]) -> str:
    if isinstance(one.event, Ended):
        how = exit_text(one.event.returncode)
        return f"{one.process} exited at {one.at_s:.1f} s of the run with {how}"
    return f"{one.process} {one.event.text}"


# ---- resource usage


def _cpu_text(expectation: Expectation) -> str:
    parts = [
        f"{noun} below {expectation.get(key):g} %"
        for key, noun in (("below", "on average"), ("peak", "at any moment"))
        if expectation.get(key) is not None
    ]
    return f"CPU of {expectation.subject} {' and '.join(parts)}{times_text(expectation)}"


@with_window(_cpu_text)
def cpu(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    loads: dict[str, list[float]] = {}
    for sample in _samples(expectation, facts, when):
        if sample.cpu_percent is not None:
            loads.setdefault(sample.process, []).append(sample.cpu_percent)
    if not when.closed or not loads:
        return when.not_yet(seen="nothing was measured")
    below, peak = (expectation.get(key, INFINITY) for key in ("below", "peak"))
    mean, name = max((statistics.fmean(values), name) for name, values in loads.items())
    most, peak_name = max((max(values), name) for name, values in loads.items())
    seen = f"{name} {mean:.1f} % on average, {peak_name} {most:.1f} % at most"
    is_over = mean >= below or most >= peak
    make = when.violated if is_over else when.met
    return make(seen=seen, value=mean, unit="%", about=(name,) * is_over)


def _samples(expectation: Expectation, facts: Facts, when: Window) -> list[UsageSample]:
    names = facts.named(expectation.subject)
    return [s for s in facts.samples if s.process in names and s.at_s in when]


def _memory_text(expectation: Expectation) -> str:
    below, growth = expectation.get("below"), expectation.get("growth")
    parts = [] if below is None else [f"is below {below / _MB:g} MB"]
    parts += [] if growth is None else [f"grows by less than {growth_text(growth)}"]
    return f"memory of {expectation.subject} {' and '.join(parts)}{times_text(expectation)}"


def growth_text(bytes_per_s: float) -> str:
    """`1.5 MB/min`."""
    return f"{bytes_per_s * _MINUTE_S / _MB:.3g} MB/min"


@with_window(_memory_text)
def memory(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    """Of its size and its growth the one that is not met, else that of the size."""
    samples = [s for s in _samples(expectation, facts, when) if s.memory_bytes is not None]
    if not samples:
        return when.not_yet(seen="nothing was measured")
    verdicts = []
    if expectation.get("below") is not None:
        verdicts.append(_size(expectation.get("below"), samples, when))
    if expectation.get("growth") is not None:
        verdicts.append(_growth(expectation.get("growth"), facts, samples, when))
    return max(verdicts, key=lambda verdict: _RANK[verdict.outcome])


def _size(below: int, samples: Sequence[UsageSample], when: Window) -> Verdict:
    largest = max(samples, key=lambda sample: sample.memory_bytes or 0)
    size, process = largest.memory_bytes or 0, largest.process
    seen = f"{process} {size / _MB:.1f} MB at {largest.at_s:.1f} s of the run"
    details: dict[str, Any] = {"seen": seen, "value": size / _MB, "unit": "MB"}
    if size >= below:
        return when.violated(at_s=largest.at_s, about=(process,), **details)
    return when.so_far(**details)


def _growth(below: float, facts: Facts, samples: Sequence[UsageSample], when: Window) -> Verdict:
    """Of the process that grows most, over the time that each has run since its start-up."""
    found: dict[str, float] = {}
    for name in dict.fromkeys(sample.process for sample in samples):
        starts = [e.at_s for e in facts.of(Started, name) if e.at_s <= when.to_s]
        from_s = max(starts, default=0.0) + START_UP_S
        own = [s for s in samples if s.process == name and s.at_s >= from_s]
        slope = growth_per_s([(s.at_s, s.memory_bytes or 0) for s in own])
        if slope is not None:
            found[name] = slope
    if not found or not when.closed:
        return when.not_yet(seen=f"nothing ran {GROWTH_S:g} s longer than its start-up")
    process, slope = max(found.items(), key=lambda item: item[1])
    seen = f"{process} {'+' if slope >= 0 else ''}{growth_text(slope)}"
    is_over = slope >= below
    make = when.violated if is_over else when.met
    value = slope * _MINUTE_S / _MB
    return make(seen=seen, value=value, unit="MB/min", about=(process,) * is_over)
