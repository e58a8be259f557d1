"""Judges of when messages come: pauses between them, and how old they are."""

from __future__ import annotations

from launcher.base.document.quantities import seconds_text
from launcher.smoke.expect.expectation import START, Expectation, Verdict
from launcher.smoke.judges import explain
from launcher.smoke.judges.common import Window, condition_text, times_text, with_window
from launcher.smoke.judges.time_series import MIN_MESSAGES, Pause, latency_s, longest_gap
from launcher.smoke.judges.traffic import fitting, sent_in, sent_s, silence
from launcher.smoke.observe.facts import Facts, ObservedMessage

_DAY_S = 86_400.0


def duration_text(value_s: float) -> str:
    """`50 ms`, `2 s`: as one would write a limit."""
    return f"{value_s * 1000:g} ms" if value_s < 1 else f"{value_s:g} s"


# ---- pauses


def _gap_text(expectation: Expectation) -> str:
    return _limit_text("gaps", "are", expectation)


def _limit_text(what: str, verb: str, expectation: Expectation) -> str:
    messages = f"{expectation.subject}{condition_text(expectation)}"
    below = duration_text(expectation.get("below"))
    return f"{what} of {messages} {verb} below {below}{times_text(expectation)}"


@with_window(_gap_text)
def gap(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    """Without `after`, from the first message on."""
    received, times = sent_in(when, expectation, facts)
    if not when.closed:
        return when.open(seen=f"{len(times)} messages")
    about = explain.processes_on(expectation.subject, facts)
    if not times:
        guess = silence(expectation, facts, received)
        return when.violated(seen="no message", guess=guess, about=about)
    counts_start = expectation.after != START
    longest = longest_gap(times, when.from_s, when.to_s, counts_start=counts_start)
    assert longest is not None  # there are messages
    seen = f"{_pause_text(longest)} ({len(times)} messages)"
    if longest.length_s < expectation.get("below"):
        return when.met(seen=seen, value=longest.length_s, unit="s")
    guess = explain.wrong_rate(expectation.subject, facts, is_slow=True)
    return when.violated(
        seen=seen,
        at_s=longest.start_s,
        value=longest.length_s,
        unit="s",
        guess=guess,
        about=about,
    )


def _pause_text(pause: Pause) -> str:
    if pause.is_open:
        return f"silent since {pause.start_s:.1f} s of the run, for {seconds_text(pause.length_s)}"
    return f"{seconds_text(pause.length_s)} from {pause.start_s:.1f} s of the run"


# ---- latency


def _latency_text(expectation: Expectation) -> str:
    return _limit_text("latency", "is", expectation)


@with_window(_latency_text)
def latency(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    """From the stamp in a message, else from its publication."""
    received = [m for m in facts.received(expectation.subject) if m.at_s in when]
    delays = [_delay_s(m) for m in fitting(expectation, received)]
    if not when.closed:
        return when.open(seen=f"{len(delays)} messages")
    about = explain.processes_on(expectation.subject, facts)
    if len(delays) < MIN_MESSAGES:
        guess = silence(expectation, facts, received)
        seen = f"{len(delays)} messages are too few for a latency"
        return when.violated(seen=seen, guess=guess, about=about)
    value_s = latency_s(delays)
    seen = f"{duration_text(round(value_s, 4))} in 95 % of {len(delays)} messages"
    if value_s < expectation.get("below"):
        return when.met(seen=seen, value=value_s, unit="s")
    guess = "its stamps are no times of day: simulated time?" if value_s > _DAY_S else None
    return when.violated(seen=seen, value=value_s, unit="s", guess=guess, about=about)


def _delay_s(message: ObservedMessage) -> float:
    begin_s = sent_s(message) if message.stamp_s is None else message.stamp_s
    return message.at_s - begin_s
