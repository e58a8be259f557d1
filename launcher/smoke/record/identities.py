"""Expectations about ids: fields whose values do not repeat."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from launcher.smoke.expect.conditions import Fields, json_of, values_at
from launcher.smoke.observe.facts import ObservedMessage
from launcher.smoke.record.runs import RecordedExpectation, Runs
from launcher.smoke.record.topics import MANY_MESSAGES, names_of


def identities(runs: Runs) -> Iterator[RecordedExpectation]:
    """`unique`, for fields that are called an id; numbers and times may not repeat by chance."""
    for name in names_of(runs):
        received = [run.facts.received(name) for run in runs]
        if min(map(len, received)) < MANY_MESSAGES:
            continue
        for field in _ids(received[0][0].content):
            if all(_are_unique(messages, field) for messages in received):
                numbers = " and ".join(str(len(messages)) for messages in received)
                yield RecordedExpectation(
                    {"unique": name, "key": field}, f"seen {numbers} messages"
                )


def _ids(content: Any) -> list[str]:
    parts = (part for part in (content, json_of(content)) if isinstance(part, Mapping | Fields))
    fields = dict.fromkeys(name for part in parts for name in part)
    return [str(name) for name in fields if str(name).lower().endswith("id")]


def _are_unique(messages: Sequence[ObservedMessage], field: str) -> bool:
    try:
        values = [values_at(message.content, [field])[0] for message in messages]
    except LookupError:
        return False
    is_plain = all(isinstance(value, str | int) for value in values)
    return is_plain and len(set(values)) == len(values)
