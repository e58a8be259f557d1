"""What may still be started, and so whether it is worth waiting for a node that is late."""

from __future__ import annotations

import fnmatch
import itertools
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

from launcher.base.model.run_events import Ended, Started
from launcher.run.requests.process_selection import ProcessNames
from launcher.smoke.expect.expectation import READY, STOP, Decision, Expectation
from launcher.smoke.expect.steps import Step
from launcher.smoke.judges import judge
from launcher.smoke.judges.common import EVENT_LATENCY_S
from launcher.smoke.observe.facts import Facts, ProcessEvent, label_of
from launcher.smoke.preflight.forecast import Forecast, ForecastTime

SETTLE_S = 2.0  # until what a timer or an exit causes has been started
# These start a process, or make a node start something.
_STARTING = ("start", "restart", "call", "set", "publish", "send", "resume")


def lost(
    presence: Iterable[Expectation],
    facts: Facts,
    forecast: Forecast | None,
    waiting: Sequence[Step],
) -> Expectation | None:
    """The first expectation of a start whose time is over, and that nothing can still fulfil.

    `waiting` are the steps of the scenario that have not been due. Without a forecast, anything
    may still be started.
    """
    late = [e for e in presence if e.within is not None and facts.now_s > _end_s(e)]
    if not late or forecast is None or not forecast.is_certain or _has_starting_step(waiting):
        return None
    begun_s = _begun_s(forecast, facts)
    if any(not _is_past(moment, facts, begun_s) for moment in forecast.conditions):
        return None
    starts = [
        process
        for process, moment in unstarted(forecast, facts)
        if moment.cause is None or not _is_past(moment, facts, begun_s)  # a timer may be slow
    ]
    starts += _restarting(forecast, facts)
    components = forecast.components if _is_any_running(facts) else ()
    for expectation in late:
        if judge(expectation, facts).outcome is not Decision.VIOLATED:
            continue
        if not _may_come(expectation, starts, components):
            return expectation
    return None


def _end_s(expectation: Expectation) -> float:
    assert expectation.within is not None
    return expectation.within.high + EVENT_LATENCY_S


def _has_starting_step(waiting: Sequence[Step]) -> bool:
    """Whether a step that may come before the system is ready starts something."""
    owner = {moment: step for step in waiting for moment in step.moments}

    def root(step: Step) -> str:
        while step.after in owner:
            step = owner[step.after]
        return step.after

    return any(s.command.verb in _STARTING and root(s) not in (READY, STOP) for s in waiting)


def unstarted(forecast: Forecast, facts: Facts) -> Iterator[tuple[ProcessNames, ForecastTime]]:
    """The planned processes that have not been started, and when they are.

    By label: the number of a process may differ from the plan's.
    """
    started = Counter(label_of(name) for name in facts.processes())
    moments = itertools.chain(forecast.moments, itertools.repeat(ForecastTime()))
    for process, moment in zip(forecast.processes, moments, strict=False):
        if started[process.label] > 0:
            started[process.label] -= 1
        else:
            yield process, moment


def _begun_s(forecast: Forecast, facts: Facts) -> float | None:
    """From when the times of the plan count at the latest; None while that is not known.

    Timers of the launch file count from the first start, which may wait for a preparation.
    """
    at_once = sum(moment.time_s == 0.0 for moment in forecast.moments)
    starts: dict[str | None, float] = {}
    for event in facts.of(Started):
        starts.setdefault(event.process, event.at_s)
    if len(starts) < at_once:
        return None
    return sorted(starts.values())[at_once - 1] if at_once else 0.0


def _is_past(moment: ForecastTime, facts: Facts, begun_s: float | None) -> bool:
    """Whether what is due at a moment has happened, if it ever does."""
    if moment.time_s is not None:
        return begun_s is not None and facts.now_s > begun_s + moment.time_s + SETTLE_S
    if moment.cause is None:
        return False
    names = [name for name in facts.processes() if label_of(name) == moment.cause]
    ends = [facts.last_end(name) for name in names]
    return bool(names) and all(end is not None and _is_final(end, facts) for end in ends)


def _is_final(end: ProcessEvent[Ended], facts: Facts) -> bool:
    return end.event.restart_in_s is None and facts.now_s > end.at_s + SETTLE_S


def _restarting(forecast: Forecast, facts: Facts) -> Iterator[ProcessNames]:
    """The processes that have exited and are about to be started again."""
    planned = {process.label: process for process in forecast.processes}
    for name in facts.processes():
        last = facts.last_end(name)
        if last is None or last.event.restart_in_s is None:
            continue
        if not facts.was_running(name, facts.now_s):
            yield planned.get(label_of(name), ProcessNames(name, label_of(name)))


def _is_any_running(facts: Facts) -> bool:
    return any(facts.was_running(name, facts.now_s) for name in facts.processes())


def _may_come(
    expectation: Expectation, starts: Iterable[ProcessNames], components: Iterable[str | None]
) -> bool:
    """Whether one of these may be the node, or any node that has the topic.

    A process or component without a name for its node may give it any.
    """
    names: list[str | None] = [*components]
    for process in starts:
        names += process.nodes or [None]
    if expectation.kind != "node":
        return bool(names)
    return any(name is None or fnmatch.fnmatchcase(name, expectation.subject) for name in names)
