"""Judges of messages: their rate, one that satisfies conditions, or all that do."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.base.document.quantities import INFINITY, NumberRange
from launcher.smoke.expect.expectation import START, Expectation, Verdict
from launcher.smoke.judges import explain, time_series
from launcher.smoke.judges.common import (
    Window,
    condition_text,
    judged,
    shorten,
    times_text,
    with_window,
)
from launcher.smoke.observe.facts import Facts, ObservedMessage

# ---- rates


def _rate_text(expectation: Expectation) -> str:
    what = f"{expectation.subject}{condition_text(expectation)}"
    text = expectation.get("is").text
    return f"rate of {what} is {text if 'Hz' in text else f'{text} Hz'}{times_text(expectation)}"


@with_window(_rate_text)
def rate(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    received, times = sent_in(when, expectation, facts)
    if not when.closed:
        return when.open(seen=f"{len(times)} messages")
    span: NumberRange = expectation.get("is")
    if len(times) < time_series.MIN_MESSAGES:
        if span.low == 0 and not times:
            return when.met(seen="no message", value=0.0, unit="Hz")
        return when.violated(
            seen=f"{len(times)} messages are too few for a rate{_refused(expectation, received)}",
            guess=silence(expectation, facts, received),
            about=explain.processes_on(expectation.subject, facts),
        )
    counts_start = expectation.after != START
    rate_hz, seconds = time_series.rate(times, when.from_s, when.to_s, counts_start=counts_start)
    seen = f"{rate_hz:.3g} Hz ({len(times)} messages in {seconds:.1f} s)"
    silent_s = times[-1] if time_series.fell_silent(times, when.to_s) else None
    if rate_hz in span:
        return when.met(seen=seen, value=rate_hz, unit="Hz")
    return when.violated(
        seen=seen + ("" if silent_s is None else f", silent since {silent_s:.1f} s of the run"),
        at_s=silent_s,
        value=rate_hz,
        unit="Hz",
        guess=explain.wrong_rate(expectation.subject, facts, is_slow=rate_hz < span.low),
        about=explain.processes_on(expectation.subject, facts),
    )


def _refused(expectation: Expectation, received: Sequence[ObservedMessage]) -> str:
    """How many more messages there were, and why the last one of them does not count."""
    reasons = [why for _, fits, why in _judged(expectation, received) if not fits]
    if not reasons:
        return ""
    why = f" ({reasons[-1]})" if reasons[-1] else ""
    return f"; {len(reasons)} do not match{why}"


def sent_in(
    when: Window, expectation: Expectation, facts: Facts
) -> tuple[list[ObservedMessage], list[float]]:
    """What was sent in the window, and when those were that satisfy the conditions, sorted."""
    received = [m for m in facts.received(expectation.subject) if sent_s(m) in when]
    return received, sorted(sent_s(m) for m in fitting(expectation, received))


def sent_s(message: ObservedMessage) -> float:
    """The publisher's time if known: ours includes the delays of a busy machine."""
    return message.at_s if message.sent_s is None else message.sent_s


def silence(
    expectation: Expectation, facts: Facts, received: Sequence[ObservedMessage]
) -> str | None:
    """The probable cause that nothing was received; None if something was."""
    topic, qos = expectation.subject, expectation.get("qos")
    return None if received else explain.silence(topic, facts, qos)


# ---- messages


def _message_text(expectation: Expectation) -> str:
    condition = condition_text(expectation)
    if expectation.get("all"):
        return f"every message on {expectation.subject}{condition}{times_text(expectation)}"
    count: NumberRange | None = expectation.get("count")
    number = "a message" if count is None else f"{count.text} messages"
    return f"{number} on {expectation.subject}{condition}{times_text(expectation)}"


@with_window(_message_text)
def message(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    known = facts.received(expectation.subject, expectation.get("watch"))
    received = [m for m in known if m.at_s in when]
    if expectation.get("all"):
        return _all(expectation, facts, received, when)
    count: NumberRange | None = expectation.get("count")
    span = count or NumberRange(low=1, high=INFINITY, text=">= 1")
    for early, fits, _ in _judged(expectation, [m for m in known if when.is_too_early(m.at_s)]):
        if fits:
            seen = f"too early, after {when.since(early.at_s)}: {short(early)}"
            return when.violated(seen=seen, at_s=early.at_s)
    found = _judged(expectation, received)
    suited = [m for m, fits, _ in found if fits]
    reasons = [why for _, _, why in found if why]
    if len(suited) > span.high:
        at_s = suited[int(span.high)].at_s
        seen = f"{len(suited)}, one too many after {when.since(at_s)}: {short(suited[-1])}"
        return when.violated(seen=seen, at_s=at_s, value=len(suited))
    if when.is_enough(len(suited), span):
        enough_s = suited[int(span.low) - 1].at_s if suited and span.low else None
        seen = f"{len(suited)}" + ("" if enough_s is None else f", after {when.since(enough_s)}")
        return when.met(seen=seen, at_s=enough_s, value=len(suited))
    return when.not_yet(
        seen=_missing(received, suited, reasons),
        guess=silence(expectation, facts, received),
        about=explain.processes_on(expectation.subject, facts),
        value=len(suited),
    )


def _judged(
    expectation: Expectation, messages: Sequence[ObservedMessage]
) -> list[tuple[ObservedMessage, bool, str | None]]:
    """Whether each satisfies the conditions, and why not."""
    results = judged(expectation, [m.content for m in messages])
    return [(m, fits, why) for m, (fits, why) in zip(messages, results, strict=True)]


def fitting(expectation: Expectation, messages: Sequence[ObservedMessage]) -> list[ObservedMessage]:
    """Those that satisfy the conditions."""
    return [m for m, fits, _ in _judged(expectation, messages) if fits]


def _missing(
    received: list[ObservedMessage], fitting: list[ObservedMessage], reasons: list[str]
) -> str:
    if not received:
        return "no message"
    text = (
        f"{len(fitting)} of {len(received)} messages match; the last one was {short(received[-1])}"
    )
    return f"{text} ({reasons[-1]})" if reasons else text


def _all(
    expectation: Expectation, facts: Facts, received: list[ObservedMessage], when: Window
) -> Verdict:
    for number, (message, fits, why) in enumerate(_judged(expectation, received), 1):
        if not fits:
            reason = f" ({why})" if why else ""
            seen = f"message {number} after {when.since(message.at_s)}: {short(message)}{reason}"
            return when.violated(seen=seen, at_s=message.at_s)
    if not received:
        return when.not_yet(seen="no message", guess=silence(expectation, facts, received))
    return when.so_far(seen=f"{len(received)} messages")


def short(message: ObservedMessage) -> str:
    """The content, or the text that it consists of."""
    content = message.content
    if isinstance(content, dict) and list(content) == ["data"]:
        content = content["data"]
    return shorten(content if isinstance(content, str) else repr(content), 160)
