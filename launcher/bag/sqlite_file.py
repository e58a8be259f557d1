"""A `.db3` file of rosbag2's sqlite3 storage, for reading."""

from __future__ import annotations

import sqlite3
from array import array
from collections.abc import Iterator
from typing import Any
from urllib.parse import quote

from launcher.bag import metadata
from launcher.bag.errors import BagError
from launcher.bag.model import Definition, Extent, Message, Span, Times, Topic


class SqliteFile:
    """Messages of a database; `path` may be that of an open descriptor. BagError."""

    unfinished: str | None = None

    def __init__(self, path: str, name: str) -> None:
        self._name = name
        try:
            self._database = sqlite3.connect(f"file:{quote(path)}?mode=ro", uri=True)
            self._columns = {row[1] for row in self._rows("PRAGMA table_info(topics)")}
            rows = self._rows("SELECT id, name FROM topics ORDER BY id")
            self._ids = {number: str(topic) for number, topic in rows}
            definitions = self._definitions()
            self.topics = [self._topic(row, definitions) for row in self._topic_rows()]
            self.extent = self._extent()
        except sqlite3.Error as error:
            raise BagError(f"cannot read {name}: {error}") from None

    def _rows(self, query: str, values: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
        return iter(self._database.execute(query, values))

    def _definitions(self) -> dict[str, Definition]:
        """From version 4 of the storage's schema on."""
        if not list(self._rows("PRAGMA table_info(message_definitions)")):
            return {}
        rows = self._rows(
            "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
        )
        return {
            str(name): Definition(text=str(text), encoding=str(encoding))
            for name, encoding, text in rows
            if text
        }

    def _topic_rows(self) -> list[tuple[Any, ...]]:
        optional = ("offered_qos_profiles", "type_description_hash")
        columns = [name if name in self._columns else "''" for name in optional]
        query = f"SELECT name, type, serialization_format, {', '.join(columns)} FROM topics"
        return list(self._rows(query))

    def _topic(self, row: tuple[Any, ...], definitions: dict[str, Definition]) -> Topic:
        name, type_name, serialization, qos, type_hash = map(str, row)
        return Topic(
            name=name,
            type=type_name,
            serialization=serialization,
            qos=metadata.qos_from(qos),
            type_hash=type_hash,
            definition=definitions.get(type_name),
        )

    def _extent(self) -> Extent:
        found = Extent()
        rows = self._rows(
            "SELECT topic_id, count(*), min(timestamp), max(timestamp) FROM messages "
            "GROUP BY topic_id"
        )
        for topic_id, count, start, end in rows:
            name = self._ids[topic_id]
            found.merge(Extent({name: count}, start, end))
        return found

    def messages(self, topics: frozenset[str] | None, span: Span) -> Iterator[Message]:
        """In the order of their times; BagError at a damaged page."""
        chosen = [one for one, name in self._ids.items() if topics is None or name in topics]
        query = (
            "SELECT topic_id, timestamp, data FROM messages WHERE timestamp >= ? AND timestamp < ? "
            f"AND topic_id IN ({', '.join('?' * len(chosen))}) ORDER BY timestamp, id"
        )
        start = -(2**63) if span.start_ns is None else span.start_ns
        end = 2**63 - 1 if span.end_ns is None else span.end_ns
        try:
            for topic_id, time_ns, data in self._rows(query, (start, end, *chosen)):
                yield Message(self._ids[topic_id], time_ns, time_ns, 0, data)
        except sqlite3.Error as error:
            raise BagError(f"{self._name} is damaged: {error}") from None

    def times(self) -> Times:
        """BagError at a damaged page."""
        found: Times = {}
        try:
            for topic_id, time_ns in self._rows("SELECT topic_id, timestamp FROM messages"):
                found.setdefault(self._ids[topic_id], array("q")).append(time_ns)
        except sqlite3.Error as error:
            raise BagError(f"{self._name} is damaged: {error}") from None
        return found

    def close(self) -> None:
        self._database.close()
