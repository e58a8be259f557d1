"""Shared by the judges: the time window of an expectation, and verdicts."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from launcher.base.document.quantities import INFINITY, NumberRange, seconds_text
from launcher.base.text import several
from launcher.output.filters import CpuLimit, TooSlowError
from launcher.smoke.expect.evaluator import EVALUATOR, NotYetError, TooExpensiveError
from launcher.smoke.expect.expectation import START, Decision, Expectation, Verdict
from launcher.smoke.observe.facts import Facts

# An event at the very end of a window may be reported this much later.
EVENT_LATENCY_S = 0.5
# CPU time for the searches of one expectation in all lines; a million take half a second.
SEARCH_S = 2.0
PATIENCE_S = 0.05  # with the evaluation of conditions
TOO_SLOW = f"the search takes more than {SEARCH_S:g} s of CPU time"


@dataclass(frozen=True, slots=True, kw_only=True)
class Window:
    """The time of an expectation, in time of the run; `closed`: all of it was observed.

    Its methods make the verdicts; `expected` is their text.
    """

    expected: str
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
        """A time of the run as time since the start of the window."""
        return seconds_text(max(0.0, at_s - self.start_s))

    def met(self, **details: object) -> Verdict:
        return met(self.expected, **details)

    def violated(self, **details: object) -> Verdict:
        return violated(self.expected, **details)

    def open(self, **details: Any) -> Verdict:
        return Verdict(outcome=Decision.OPEN, expected=self.expected, **details)

    def not_yet(self, **details: object) -> Verdict:
        """Violated when the window is closed."""
        return self.violated(**details) if self.closed else self.open(**details)

    def so_far(self, **details: object) -> Verdict:
        """Met when the window is closed."""
        return self.met(**details) if self.closed else self.open(**details)

    def is_enough(self, number: int, span: NumberRange) -> bool:
        """Whether a number that can only grow is in a span for good."""
        return number in span and (span.high == INFINITY or self.closed)


def window(expectation: Expectation, facts: Facts, expected: str = "") -> Window | None:
    """None if the step that the time counts from has not happened."""
    start_s = facts.steps.get(expectation.after)
    if start_s is None:
        return None
    within = expectation.within
    low, high = (0.0, INFINITY) if within is None else (within.low, within.high)
    return Window(
        expected=expected,
        start_s=start_s,
        from_s=start_s + low,
        to_s=facts.stop_s if within is None else start_s + high,
        closed=facts.is_over or facts.now_s >= start_s + high + EVENT_LATENCY_S,
    )


def times_text(expectation: Expectation) -> str:
    """` within 8 s after 'kill'` or ` within 5 to 8 s`."""
    span, after = expectation.within, expectation.after
    low = f"{span.low:g} to " if span is not None and span.low else ""
    within = "" if span is None else f" within {low}{span.high:g} s"
    return within + ("" if after == START else f" after '{after}'")


Judge = Callable[[Expectation, Facts], Verdict]
WindowJudge = Callable[[Expectation, Facts, Window], Verdict]


def with_window(expected: Callable[[Expectation], str]) -> Callable[[WindowJudge], Judge]:
    """Decorate a judge that takes a window; `expected` gives the text of what is expected."""

    def decorate(judge: WindowJudge) -> Judge:
        def judged(expectation: Expectation, facts: Facts) -> Verdict:
            text = expected(expectation)
            when = window(expectation, facts, text)
            if when is not None:
                return _bounded(judge, expectation, facts, when)
            if facts.is_over:
                return violated(text, seen=f"the step '{expectation.after}' never happened")
            return Verdict(outcome=Decision.OPEN, expected=text)

        return judged

    return decorate


def _bounded(judge: WindowJudge, expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    """The verdict of a judge; open while conditions are being evaluated in a run that goes on."""
    while True:
        try:
            with search_limit():
                return judge(expectation, facts, when)
        except TooExpensiveError as error:
            return when.violated(seen=str(error))
        except TooSlowError:
            return when.violated(seen=TOO_SLOW)
        except NotYetError:
            if not facts.is_over:
                return when.open(seen="it is being evaluated")


def search_limit() -> contextlib.AbstractContextManager[None]:
    """TooSlowError; other threads than the main one cannot be interrupted, and do not search."""
    is_main = threading.current_thread() is threading.main_thread()
    return CpuLimit(SEARCH_S) if is_main else contextlib.nullcontext()


def met(expected: str, **details: Any) -> Verdict:
    return Verdict(outcome=Decision.MET, expected=expected, **details)


def violated(expected: str, **details: Any) -> Verdict:
    return Verdict(outcome=Decision.VIOLATED, expected=expected, **details)


def judged(expectation: Expectation, contents: Sequence[Any]) -> list[tuple[bool, str | None]]:
    """Whether each content satisfies `where` and `fields`, and why not.

    TooExpensiveError, NotYetError.
    """
    # The main thread has the scenario to run; the others wait for an answer of a service.
    patience_s = PATIENCE_S if threading.current_thread() is threading.main_thread() else None
    return EVALUATOR.judged(_conditions(expectation), contents, patience_s)


def forget(expectation: Expectation, contents: Sequence[Any]) -> None:
    """Whether these contents satisfy its conditions is not asked again."""
    EVALUATOR.forget(_conditions(expectation), contents)


def _conditions(expectation: Expectation) -> list[Any]:
    given = (expectation.get(name) for name in ("where", "fields"))
    return [one for one in given if one is not None]


def condition_text(expectation: Expectation) -> str:
    texts = [expectation.get(name).text for name in ("where", "fields") if expectation.get(name)]
    return f" with {' and '.join(texts)}" if texts else ""


def listed(names: Iterable[str]) -> str:
    """Sorted unique names, or `none`."""
    return several(sorted(set(names)), most=8) or "none"


def shorten(text: str, length: int = 200) -> str:
    return text if len(text) <= length else f"{text[: length - 3]}..."
