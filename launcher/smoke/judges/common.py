"""What the judges share: looking for the first moment at which something held."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

from launcher.smoke.expect.expectation import Expectation, Outcome, Period, Verdict, period
from launcher.smoke.observe.facts import START, Facts, GraphSeen

T = TypeVar("T")


def first_time(
    states: Sequence[T], holds: Callable[[T], bool], when: Period, at: Callable[[T], float]
) -> float | None:
    """When a state that lasts until the next one first held in the period; None if it did not."""
    for index, state in enumerate(states):
        following = states[index + 1] if index + 1 < len(states) else None
        ends_s = float("inf") if following is None else at(following)
        if at(state) <= when.to_s and ends_s > when.from_s and holds(state):
            return max(at(state), when.from_s)
    return None


def since(facts: Facts, describe: Callable[[GraphSeen], object]) -> float | None:
    """Since when the graph has been as it is now, as far as `describe` tells; None without one."""
    seen = [graph for graph in facts.graphs if graph.at_s <= facts.stop_s]
    if not seen:
        return None
    last = describe(seen[-1])
    begin_s = seen[-1].at_s
    for graph in reversed(seen):
        if describe(graph) != last:
            break
        begin_s = graph.at_s
    return begin_s


def missed_step(expectation: Expectation, facts: Facts, expected: str) -> Verdict:
    """The verdict where the step that the time counts from has not happened."""
    if not facts.is_over:
        return Verdict(outcome=Outcome.OPEN, expected=expected)
    return Verdict(
        outcome=Outcome.VIOLATED,
        expected=expected,
        seen=f"the step '{expectation.after}' never happened",
    )


def not_yet(when: Period, expected: str, **details: Any) -> Verdict:
    """Open as long as there is time, then violated."""
    outcome = Outcome.VIOLATED if when.closed else Outcome.OPEN
    return Verdict(outcome=outcome, expected=expected, **details)


def met(expected: str, **details: Any) -> Verdict:
    """It holds."""
    return Verdict(outcome=Outcome.MET, expected=expected, **details)


def violated(expected: str, **details: Any) -> Verdict:
    """It does not, and no time will change that."""
    return Verdict(outcome=Outcome.VIOLATED, expected=expected, **details)


def with_period(
    judge: Callable[[Expectation, Facts, Period, str], Verdict],
    expected: Callable[[Expectation], str],
) -> Callable[[Expectation, Facts], Verdict]:
    """A judge of a kind from one that needs the period and the sentence of what is expected."""

    def judged(expectation: Expectation, facts: Facts) -> Verdict:
        sentence = expected(expectation)
        when = period(expectation, facts)
        if when is None:
            return missed_step(expectation, facts, sentence)
        return judge(expectation, facts, when, sentence)

    return judged


def several(names: Iterable[str], most: int = 4) -> str:
    """`a, b and 3 more`."""
    known = list(names)
    shown = ", ".join(known[:most])
    return shown if len(known) <= most else f"{shown} and {len(known) - most} more"


def listed(names: Iterable[str]) -> str:
    """Names for a sentence, or `none`."""
    return several(sorted(set(names)), most=8) or "none"


def started_at(expectation: Expectation) -> str:
    """`after the start` or `after 'kill'`."""
    step = expectation.after
    return "after the start" if step == START else f"after '{step}'"
