"""Judges of values in several messages: they do not repeat, refer to others, or are counted."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from launcher.base import strict_json
from launcher.base.document.quantities import INFINITY
from launcher.smoke.expect.expectation import Expectation, Verdict
from launcher.smoke.expect.message_conditions import Fields, values_at
from launcher.smoke.judges import explain
from launcher.smoke.judges.common import Window, condition_text, times_text, with_window
from launcher.smoke.judges.traffic import fitting, sent_s, short
from launcher.smoke.observe.facts import Facts, ObservedMessage

# Messages of different topics may arrive in another order than they were sent in.
ARRIVAL_S = 1.0
LAG_S = 1.0


class _NoKeyError(Exception):
    """A message lacks a field; the text has both."""


def _found(expectation: Expectation, message: ObservedMessage) -> list[Any]:
    """The values of the key; _NoKeyError."""
    try:
        return values_at(message.content, expectation.get("key"))
    except LookupError as error:
        raise _NoKeyError(f"{error.args[0]}: {short(message)}") from None


def _values(expectation: Expectation, message: ObservedMessage) -> str:
    """The values of the key as text; _NoKeyError."""
    return _text_of(_found(expectation, message))


def _text_of(values: Iterable[Any]) -> str:
    return ", ".join(strict_json.packed(value, sort_keys=True, default=_plain) for value in values)


def _plain(value: Any) -> Any:
    return {name: value[name] for name in value} if isinstance(value, Fields) else str(value)


def _key_text(expectation: Expectation) -> str:
    return " and ".join(expectation.get("key"))


def _messages(expectation: Expectation, facts: Facts, when: Window) -> list[ObservedMessage]:
    """Those on its topic that satisfy the conditions, in order of publication."""
    known = facts.received(expectation.subject, expectation.get("watch"))
    return sorted(fitting(expectation, [m for m in known if m.at_s in when]), key=sent_s)


def _silence(topic: str, facts: Facts, when: Window) -> Verdict:
    guess = explain.silence(topic, facts)
    return when.not_yet(seen=f"no message on {topic}", guess=guess)


def _fault(seen: str, message: ObservedMessage, facts: Facts, when: Window) -> Verdict:
    about = explain.processes_on(message.topic, facts)
    text = f"{seen} after {when.since(message.at_s)}: {short(message)}"
    return when.violated(seen=text, at_s=message.at_s, about=about)


# ---- unique


def _unique_text(expectation: Expectation) -> str:
    messages = f"messages on {expectation.subject}{condition_text(expectation)}"
    return f"no two {messages} have the same {_key_text(expectation)}{times_text(expectation)}"


@with_window(_unique_text)
def unique(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    received = _messages(expectation, facts, when)
    if not received:
        return _silence(expectation.subject, facts, when)
    first: dict[str, ObservedMessage] = {}
    for message in received:
        try:
            values = _values(expectation, message)
        except _NoKeyError as error:
            return when.violated(seen=str(error), at_s=message.at_s)
        if values in first:
            seen = f"{values} was there after {when.since(first[values].at_s)}, and again"
            return _fault(seen, message, facts, when)
        first[values] = message
    return when.so_far(seen=f"{len(received)} messages", value=len(received))


# ---- refers


def _refers_text(expectation: Expectation) -> str:
    messages = f"every message on {expectation.subject}{condition_text(expectation)}"
    before = f"that {expectation.get('to')} had before"
    return f"{messages} has a {_key_text(expectation)} {before}{times_text(expectation)}"


@with_window(_refers_text)
def refers(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    received = _messages(expectation, facts, when)
    if not received:
        return _silence(expectation.subject, facts, when)
    try:
        before_s = _first_times(expectation, facts)
        for message in received:
            values = _values(expectation, message)
            is_due = when.closed or facts.now_s - message.at_s > ARRIVAL_S
            if before_s.get(values, INFINITY) - ARRIVAL_S > sent_s(message) and is_due:
                seen = f"{values} was not on {expectation.get('to')} before, but"
                return _fault(seen, message, facts, when)
    except _NoKeyError as error:
        return when.violated(seen=str(error))
    return when.so_far(seen=f"{len(received)} messages", value=len(received))


def _first_times(expectation: Expectation, facts: Facts) -> dict[str, float]:
    """When each value was first published on the other topic; _NoKeyError."""
    first_s: dict[str, float] = {}
    for message in facts.received(expectation.get("to"), expectation.get("other_watch")):
        values = _values(expectation, message)
        first_s[values] = min(sent_s(message), first_s.get(values, sent_s(message)))
    return first_s


# ---- tally


def _tally_text(expectation: Expectation) -> str:
    messages = f"messages on {expectation.subject}{condition_text(expectation)}"
    number = f"'{expectation.get('number').pattern}' in messages on {expectation.get('in')}"
    key = _key_text(expectation)
    return f"{number} is the number of different {key} of {messages}{times_text(expectation)}"


@with_window(_tally_text)
def tally(expectation: Expectation, facts: Facts, when: Window) -> Verdict:
    topic, lag_s = expectation.get("in"), expectation.get("lag", LAG_S)
    known = facts.received(topic, expectation.get("other_watch"))
    counts = [message for message in known if message.at_s in when]
    if not counts:
        return _silence(topic, facts, when)
    try:
        times_s = _new_times(expectation, facts)
    except _NoKeyError as error:
        return when.violated(seen=str(error))
    for message in counts:
        found = expectation.get("number").search(_text(message))
        if found is None or not found[1].isdecimal():
            return _fault("no number", message, facts, when)
        if not when.closed and facts.now_s <= sent_s(message) + lag_s + ARRIVAL_S:
            break  # what it counts may still arrive
        low, high = (_until(times_s, sent_s(message) + by_s) for by_s in (-lag_s, lag_s))
        if not low <= int(found[1]) <= high:
            number = f"{low}" if low == high else f"{low} to {high}"
            return _fault(f"{found[1]} instead of {number}", message, facts, when)
    return when.so_far(seen=f"{len(counts)} messages, {len(times_s)} counted", value=len(times_s))


def _new_times(expectation: Expectation, facts: Facts) -> list[float]:
    """When each value was first published, whatever the window: counts begin with the run."""
    first_s: dict[str, float] = {}
    known = facts.received(expectation.subject, expectation.get("watch"))
    for message in sorted(fitting(expectation, known), key=sent_s):
        found = _found(expectation, message)
        is_list = len(found) == 1 and isinstance(found[0], list)
        for values in [[one] for one in found[0]] if is_list else [found]:
            first_s.setdefault(_text_of(values), sent_s(message))
    return list(first_s.values())


def _until(times_s: Sequence[float], at_s: float) -> int:
    return sum(time_s <= at_s for time_s in times_s)


def _text(message: ObservedMessage) -> str:
    content = message.content
    text = content.get("data") if isinstance(content, dict) else None
    return text if isinstance(text, str) else strict_json.packed(content)
