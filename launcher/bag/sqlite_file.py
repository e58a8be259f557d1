"""A `.db3` file of rosbag2's sqlite3 storage, for reading."""

from __future__ import annotations

import contextlib
import os
import sqlite3
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import quote

from launcher.bag import metadata
from launcher.bag.bag_model import (
    BagError,
    ChannelTopic,
    Definition,
    Extent,
    Message,
    Span,
    TimesBlock,
    Topic,
    merged,
    never,
    time_blocks,
)

_TABLES = ("topics", "messages", "message_definitions")
_STEPS = 10_000  # of SQLite, between looks at Ctrl-C: less than a millisecond
_GENERATED = (2, 3)  # columns, in PRAGMA table_xinfo
_ABORTED = "interrupted"  # SQLite's message where the progress handler ends a query


class SqliteFile:
    """Messages of a database; `path` may be that of an open descriptor. BagError."""

    unfinished: str | None = None

    def __init__(self, path: str, name: str) -> None:
        self._name = name
        self._stopped: Callable[[], bool] = never
        self.notes: list[str] = []
        if not os.path.getsize(path):
            raise BagError(f"{name} is empty")
        try:
            self._database = sqlite3.connect(f"file:{quote(path)}?mode=ro", uri=True)
        except sqlite3.Error as error:
            raise BagError(f"cannot read {name}: {error}") from None
        try:
            with self._guarded("cannot read {}: {}"):
                self._read_head()
        except BaseException:
            self._database.close()
            raise

    def _read_head(self) -> None:
        # Called while a query runs: Python raises KeyboardInterrupt only in Python code.
        self._database.set_progress_handler(lambda: self._stopped(), _STEPS)
        self._refuse_programs()
        self._columns = {row[1] for row in self._rows("PRAGMA table_info(topics)")}
        rows = self._rows("SELECT id, name FROM topics ORDER BY id")
        self._ids = {number: str(topic) for number, topic in rows}
        definitions = self._definitions()
        self._extents = dict(self._read_extents())
        self.parts = [
            ChannelTopic(
                number, self._topic(row, definitions), self._extents.get(number, Extent()).total
            )
            for number, *row in self._topic_rows()
        ]
        self.leave_out(frozenset())

    def leave_out(self, keys: frozenset[int]) -> None:
        """Without these rows of the topics from now on."""
        self._left_out = keys
        self.topics = merged(part.topic for part in self.parts if part.key not in keys)
        self.extent = Extent()
        for number, extent in self._extents.items():
            if number not in keys:
                self.extent.merge(extent)

    @contextlib.contextmanager
    def _guarded(self, sentence: str) -> Iterator[None]:
        """BagError for errors of SQLite; KeyboardInterrupt where it was interrupted."""
        try:
            yield
        except sqlite3.OperationalError as error:
            if str(error) == _ABORTED:
                if self._stopped():
                    return
                raise KeyboardInterrupt from None
            raise BagError(sentence.format(self._name, error), hint=self._hint(error)) from None
        except (sqlite3.Error, MemoryError, OverflowError, ValueError) as error:
            raise BagError(sentence.format(self._name, error), hint=self._hint(error)) from None

    def _hint(self, error: Exception) -> str | None:
        if "not a database" in str(error):
            return None
        return f"what sqlite3 can read of it: sqlite3 {self._name} .recover | sqlite3 NEW.db3"

    def _refuse_programs(self) -> None:
        """A view, a virtual table or a generated column computes what it has, perhaps for ever."""
        query = (
            "SELECT name, sql FROM sqlite_master WHERE type != 'index' AND name COLLATE NOCASE "
            f"IN ({', '.join('?' * len(_TABLES))})"
        )
        for name, sql in self._rows(query, _TABLES):
            if not str(sql).startswith("CREATE TABLE"):
                kind = " ".join(str(sql).split()[1:2]).lower() or "nothing"
                raise BagError(f"{self._name} is no bag: {name} is a {kind}, not a table")
        for table in _TABLES:
            for row in self._rows(f"PRAGMA table_xinfo({table})"):
                if row[6] in _GENERATED:
                    raise BagError(f"{self._name} is no bag: {table}.{row[1]} is computed")

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
        query = f"SELECT id, name, type, serialization_format, {', '.join(columns)} FROM topics"
        return list(self._rows(query))

    def _topic(self, row: list[Any], definitions: dict[str, Definition]) -> Topic:
        texts = ("" if value is None else str(value) for value in row)
        name, type_name, serialization, qos, type_hash = texts
        return Topic(
            name=name,
            type=type_name,
            serialization=serialization,
            qos=metadata.known_qos(name, qos, self.notes),
            type_hash=type_hash,
            definition=definitions.get(type_name),
        )

    def _read_extents(self) -> Iterator[tuple[int, Extent]]:
        """Of each row of the topics that has messages."""
        rows = self._rows(
            "SELECT topic_id, count(*), min(timestamp), max(timestamp) FROM messages "
            "GROUP BY topic_id"
        )
        for topic_id, count, start, end in rows:
            name = self._topic_of(topic_id)
            yield topic_id, Extent({name: count}, _time(start), _time(end))

    def _topic_of(self, topic_id: object) -> str:
        """ValueError if there is no such topic."""
        if topic_id not in self._ids:
            raise ValueError(f"a message belongs to the unknown topic {topic_id!r:.40}")
        return self._ids[topic_id]

    def messages(
        self, topics: frozenset[str] | None, span: Span, stopped: Callable[[], bool] = never
    ) -> Iterator[Message]:
        """In the order of their times; BagError at a damaged page."""
        chosen = [
            one
            for one, name in self._ids.items()
            if one not in self._left_out and (topics is None or name in topics)
        ]
        limits = [(">=", span.start_ns), ("<", span.end_ns)]
        times = "".join(f"timestamp {sign} ? AND " for sign, ns in limits if ns is not None)
        query = (
            f"SELECT topic_id, timestamp, data FROM messages WHERE {times}"
            f"topic_id IN ({', '.join('?' * len(chosen))}) ORDER BY timestamp, id"
        )
        values = (*(ns for _, ns in limits if ns is not None), *chosen)
        self._stopped = stopped
        with self._damage():
            for topic_id, time_ns, data in self._rows(query, values):
                if not isinstance(data, bytes):
                    raise ValueError("a message has no bytes")
                time_ns = _time(time_ns)
                yield Message(self._topic_of(topic_id), time_ns, time_ns, 0, data)

    def _damage(self) -> contextlib.AbstractContextManager[None]:
        return self._guarded("{} is damaged: {}")

    def times(self) -> Iterator[TimesBlock]:
        """BagError at a damaged page."""
        with self._damage():
            rows = self._rows("SELECT topic_id, timestamp FROM messages ORDER BY timestamp")
            yield from time_blocks(
                (self._topic_of(topic_id), _time(time_ns))
                for topic_id, time_ns in rows
                if topic_id not in self._left_out
            )

    def close(self) -> None:
        self._database.close()


def _time(value: object) -> int:
    """ValueError if a row has something else; columns of SQLite have any type."""
    if type(value) is not int:
        raise ValueError("a message has no time")
    if value < 0:
        raise ValueError("a message has an impossible time")
    return value
