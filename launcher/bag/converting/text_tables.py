"""Messages as text, for other programs: CSV and JSON lines."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TextIO

from launcher.bag.bag_model import BagError, Message, Span
from launcher.bag.converting.merged_bags import Merged
from launcher.bag.decode import Decoder, cell, decoder, field_of, leaves, plain
from launcher.base import strict_json

Notes = Callable[[str], None]


class Readable:
    """The topics that can be decoded; the others are left out, with a sentence to `notes`.

    `first` has the first message of each one that has any. BagError if none can be decoded.
    """

    def __init__(self, merged: Merged, span: Span, notes: Notes) -> None:
        self.decoders: dict[str, Decoder] = {}
        self.first: dict[str, Any] = {}
        problems: dict[str, BagError] = {}
        for topic in merged.topics:
            message = next(merged.messages(span, frozenset({topic.name})), None)
            if message is None:
                continue
            try:
                decode = self.decoders[topic.name] = decoder(topic)
                self.first[topic.name] = decode(message.data)
            except BagError as error:
                problems[topic.name] = error
        if problems and not self.first:
            raise next(iter(problems.values()))
        for name, problem in problems.items():
            merged.leave_out(name)
            hint = f"\nhint: {problem.hint}" if problem.hint else ""
            notes(f"{problem.message}; the topic is left out{hint}")
        self.topics = merged.topics


class JsonLines:
    """A line for each message, with all of it, or with `fields`: path to value."""

    def __init__(self, readable: Readable, stream: TextIO, fields: Sequence[str]) -> None:
        self._decoders = readable.decoders
        self._stream = stream
        self._fields = fields

    def write(self, message: Message) -> None:
        decoded = self._decoders[message.topic](message.data)
        document = {
            "topic": message.topic,
            "time_ns": message.log_ns,
            "publish_ns": message.publish_ns,
            "message": self._contents(decoded),
        }
        self._stream.write(strict_json.dumps(document, ensure_ascii=False) + "\n")

    def _contents(self, decoded: object) -> Any:
        if not self._fields:
            return plain(decoded)
        return {path: plain(field_of(decoded, path)) for path in self._fields}


class Csv:
    """A row for each message: time, topic if there are several, and `fields`, or all fields.

    The cell of a field that a topic does not have is empty.
    """

    def __init__(self, readable: Readable, stream: TextIO, fields: Sequence[str]) -> None:
        self._decoders = readable.decoders
        self._writer = csv.writer(stream, lineterminator="\n")
        self._has_topic = len(readable.topics) > 1
        self._columns, self._own = self._columns_of(readable, fields)
        topic = ["topic"] if self._has_topic else []
        self._writer.writerow(["time", *topic, *self._columns])

    @staticmethod
    def _columns_of(
        readable: Readable, fields: Sequence[str]
    ) -> tuple[list[str], dict[str, frozenset[str]]]:
        """The columns, and those of each topic, as its first message shows."""
        own: dict[str, list[str]] = {}
        problems: list[BagError] = []
        for topic, decoded in readable.first.items():
            own[topic] = list(leaves(decoded))
            if fields:
                own[topic], found = _having(decoded, fields)
                problems += found
        columns = list(fields) or list(dict.fromkeys(path for one in own.values() for path in one))
        for path in fields:
            if own and not any(path in one for one in own.values()):
                raise next(one for one in problems if f"'{path}'" in one.message)
        return columns, {name: frozenset(paths) for name, paths in own.items()}

    def write(self, message: Message) -> None:
        decoded = self._decoders[message.topic](message.data)
        own = self._own[message.topic]
        seconds, rest = divmod(message.log_ns, 10**9)
        topic = [message.topic] if self._has_topic else []
        cells = (cell(field_of(decoded, path)) if path in own else "" for path in self._columns)
        self._writer.writerow([f"{seconds}.{rest:09}", *topic, *cells])


def _having(decoded: object, fields: Iterable[str]) -> tuple[list[str], list[BagError]]:
    """The fields that a message has, and why it lacks the others."""
    found, problems = [], []
    for path in fields:
        try:
            field_of(decoded, path)
            found.append(path)
        except BagError as error:
            problems.append(error)
    return found, problems
