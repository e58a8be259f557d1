"""Judges of messages: rates, one that satisfies a condition, all that satisfy one."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from launcher.smoke.expect.expectation import Expectation, Outcome, Period, Verdict, times_text
from launcher.smoke.expect.quantities import Span
from launcher.smoke.judges import explain
from launcher.smoke.judges.common import met, not_yet, violated, with_period
from launcher.smoke.observe.facts import START, Facts, Message

SHORTEST = 3  # messages: fewer have no rate
SILENT_INTERVALS = 2  # of the longest one: a topic that pauses longer has stopped


def _holds(expectation: Expectation, message: Message) -> tuple[bool, str | None]:
    for name in ("where", "fields"):
        condition = expectation.get(name)
        if condition is not None:
            holds, why = condition.holds(message.content)
            if not holds:
                return False, why
    return True, None


def _condition_text(expectation: Expectation) -> str:
    texts = [expectation.get(name).text for name in ("where", "fields") if expectation.get(name)]
    return f" with {' and '.join(texts)}" if texts else ""


# ---- rates


def _rate_text(expectation: Expectation) -> str:
    what = f"{expectation.subject}{_condition_text(expectation)}"
    text = expectation.get("is").text
    return f"rate of {what} is {text if 'Hz' in text else f'{text} Hz'}{times_text(expectation)}"


def _rate(expectation: Expectation, facts: Facts, when: Period, expected: str) -> Verdict:
    heard = [m for m in facts.heard(expectation.subject) if _holds(expectation, m)[0]]
    times = sorted(_sent(m) for m in heard if _sent(m) in when)
    if not when.closed:
        return Verdict(outcome=Outcome.OPEN, expected=expected, seen=f"{len(times)} messages")
    span: Span = expectation.get("is")
    if len(times) < SHORTEST:
        if span.low == 0 and not times:
            return met(expected, seen="no message", value=0.0, unit="Hz")
        return violated(
            expected,
            seen=f"{len(times)} messages are too few for a rate",
            guess=explain.silence(expectation.subject, facts),
            about=explain.processes_on(expectation.subject, facts),
        )
    rate_hz, seconds = measured(times, when, counts_start=expectation.after != START)
    seen = f"{rate_hz:.3g} Hz ({len(times)} messages in {seconds:.1f} s)"
    silent_s = times[-1] if _fell_silent(times, when) else None
    if rate_hz in span:
        return met(expected, seen=seen, value=rate_hz, unit="Hz")
    return violated(
        expected,
        seen=seen + ("" if silent_s is None else f", silent since {silent_s:.1f} s of the run"),
        at_s=silent_s,
        value=rate_hz,
        unit="Hz",
        guess=explain.slow(expectation.subject, facts, is_slow=rate_hz < span.low),
        about=explain.processes_on(expectation.subject, facts),
    )


def measured(times: Sequence[float], when: Period, *, counts_start: bool) -> tuple[float, float]:
    """(rate, time it was measured over): intervals by time, so that nothing hangs on the edges.

    A topic that fell silent is measured up to the end, and one that began late after a step from
    that step on.
    """
    first_s, last_s = times[0], times[-1]
    longest = max(b - a for a, b in itertools.pairwise(times))
    intervals = len(times) - 1
    if _fell_silent(times, when):
        last_s = when.to_s
    if counts_start and first_s - when.from_s > SILENT_INTERVALS * longest:
        first_s = when.from_s
    seconds = max(last_s - first_s, 1e-9)
    return intervals / seconds, seconds


def _fell_silent(times: Sequence[float], when: Period) -> bool:
    longest = max(b - a for a, b in itertools.pairwise(times))
    return when.to_s - times[-1] > SILENT_INTERVALS * longest


def _sent(message: Message) -> float:
    """The publisher's time is the truth about its timer; ours has the delays of a busy machine."""
    return message.at_s if message.sent_s is None else message.sent_s


# ---- messages


def _message_text(expectation: Expectation) -> str:
    condition = _condition_text(expectation)
    if expectation.get("all"):
        return f"every message on {expectation.subject}{condition}{times_text(expectation)}"
    count: Span | None = expectation.get("count")
    number = "a message" if count is None else f"{count.text} messages"
    return f"{number} on {expectation.subject}{condition}{times_text(expectation)}"


def _message(expectation: Expectation, facts: Facts, when: Period, expected: str) -> Verdict:
    known = _heard(expectation, facts)
    heard = [m for m in known if m.at_s in when]
    if expectation.get("all"):
        return _all(expectation, facts, heard, when, expected)
    count: Span | None = expectation.get("count")
    span = count or Span(low=1, high=float("inf"), text=">= 1")
    for early in (m for m in known if when.is_too_early(m.at_s)):
        if _holds(expectation, early)[0]:
            seen = f"too early, after {when.since(early.at_s)}: {short(early)}"
            return violated(expected, seen=seen, at_s=early.at_s)
    judged = [(m, *_holds(expectation, m)) for m in heard]
    fitting = [m for m, holds, _ in judged if holds]
    reasons = [why for _, _, why in judged if why]
    if len(fitting) > span.high:
        at_s = fitting[int(span.high)].at_s
        seen = f"{len(fitting)}, the one too many after {when.since(at_s)}: {short(fitting[-1])}"
        return violated(expected, seen=seen, at_s=at_s, value=len(fitting))
    if len(fitting) >= span.low and (span.high == float("inf") or when.closed):
        enough_s = fitting[int(span.low) - 1].at_s if fitting and span.low else None
        seen = f"{len(fitting)}" + ("" if enough_s is None else f", after {when.since(enough_s)}")
        return met(expected, seen=seen, at_s=enough_s, value=len(fitting))
    return not_yet(
        when,
        expected,
        seen=_missing(heard, fitting, reasons),
        guess=None if heard else _silence(expectation, facts),
        about=explain.processes_on(expectation.subject, facts),
        value=len(fitting),
    )


def _heard(expectation: Expectation, facts: Facts) -> Sequence[Message]:
    """The messages through the subscription that the expectation asked for."""
    return facts.heard(expectation.subject, expectation.get("watch"))


def _missing(heard: list[Message], fitting: list[Message], reasons: list[str]) -> str:
    if not heard:
        return "no message at all"
    text = f"{len(fitting)} of {len(heard)} messages fit; the last one was {short(heard[-1])}"
    return f"{text} ({reasons[-1]})" if reasons else text


def _silence(expectation: Expectation, facts: Facts) -> str | None:
    return explain.silence(expectation.subject, facts, expectation.get("qos"))


def _all(
    expectation: Expectation, facts: Facts, heard: list[Message], when: Period, expected: str
) -> Verdict:
    for number, message in enumerate(heard, 1):
        holds, why = _holds(expectation, message)
        if not holds:
            reason = f" ({why})" if why else ""
            seen = f"message {number} after {when.since(message.at_s)}: {short(message)}{reason}"
            return violated(expected, seen=seen, at_s=message.at_s)
    if not heard:
        guess = _silence(expectation, facts)
        return not_yet(when, expected, seen="no message at all", guess=guess)
    outcome = Outcome.MET if when.closed else Outcome.OPEN
    return Verdict(outcome=outcome, expected=expected, seen=f"{len(heard)} messages")


def short(message: Message, length: int = 160) -> str:
    """A message in one line."""
    content = message.content
    if isinstance(content, dict) and list(content) == ["data"]:
        content = content["data"]
    text = content if isinstance(content, str) else repr(content)
    return text if len(text) <= length else f"{text[: length - 3]}..."


rate = with_period(_rate, _rate_text)
message = with_period(_message, _message_text)
