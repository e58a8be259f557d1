"""SQLite files that compute what they have, or have values of other types."""

from __future__ import annotations

import signal
import sqlite3
import threading
from pathlib import Path

import pytest

from launcher.bag.bag_model import BagError, Span
from launcher.bag.reader import Bag
from launcher.bag.sqlite_file import SqliteFile
from tests.support.bags import foreign_bag
from tests.support.waiting import wait_until


@pytest.fixture
def database(tmp_path: Path) -> Path:
    messages: list[tuple[str, str, int, object]] = [
        ("/a", "std_msgs/msg/String", 10**18 + n, {"data": str(n)}) for n in range(3)
    ]
    return next(foreign_bag(tmp_path / "sql", messages).glob("*.db3"))


def execute(path: Path, *statements: str) -> None:
    connection = sqlite3.connect(path)
    for statement in statements:
        connection.execute(statement)
    connection.commit()
    connection.close()


ENDLESS = (
    "WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n) SELECT x AS id, "
    "1 AS topic_id, x AS timestamp, x'00' AS data FROM n"
)


@pytest.mark.parametrize(
    ("statements", "text"),
    [
        (
            ("ALTER TABLE messages RENAME TO old", f"CREATE VIEW messages AS {ENDLESS}"),
            "messages is a view, not a table",
        ),
        (
            (
                "ALTER TABLE messages RENAME TO old",
                "CREATE VIRTUAL TABLE Messages USING fts4(id, topic_id, timestamp, data)",
            ),
            "Messages is a virtual, not a table",
        ),
        (
            (
                "ALTER TABLE messages RENAME TO old",
                "CREATE TABLE messages(id, topic_id, timestamp, data AS (zeroblob(1000000000)))",
            ),
            "messages.data is computed",
        ),
    ],
)
def test_tables_that_compute_what_they_have(database: Path, statements: tuple[str, ...], text: str):
    execute(database, *statements)
    with pytest.raises(BagError) as caught:
        Bag(str(database))
    assert caught.value.message == f"{database} is no bag: {text}"


@pytest.mark.parametrize(
    ("statement", "text"),
    [
        ("UPDATE messages SET data = 'text'", "a message has no bytes"),
        ("UPDATE messages SET timestamp = 'soon'", "a message has no time"),
        ("UPDATE messages SET timestamp = -5", "a message has an impossible time"),
        ("UPDATE messages SET topic_id = 77", "a message belongs to the unknown topic 77"),
        ("UPDATE messages SET topic_id = x'00'", "a message belongs to the unknown topic"),
    ],
)
def test_rows_of_other_types(database: Path, statement: str, text: str):
    execute(database, statement)
    with pytest.raises(BagError, match=text):
        list(Bag(str(database)).messages())


def endless(database: Path) -> SqliteFile:
    """A file whose query of all messages takes for ever."""
    file = SqliteFile(str(database), str(database))
    execute(database, "ALTER TABLE messages RENAME TO old", f"CREATE VIEW messages AS {ENDLESS}")
    return file


def test_a_signal_ends_a_long_query(database: Path):
    def interrupted() -> bool:
        signal.raise_signal(signal.SIGINT)  # as it would be handled while SQLite is at work
        return False

    with pytest.raises(KeyboardInterrupt):
        list(endless(database).messages(None, Span(2**62, 2**62 + 1), interrupted))


def test_a_long_query_in_a_thread_ends_when_it_is_stopped(database: Path, tmp_path: Path):
    stop = threading.Event()
    asked = threading.Event()

    def stopped() -> bool:
        asked.set()
        return stop.is_set()

    found: list[object] = []

    def read() -> None:
        file = endless(database)
        found.extend(file.messages(None, Span(2**62, 2**62 + 1), stopped))

    thread = threading.Thread(target=read)
    thread.start()
    wait_until(asked.is_set, "the query to run")
    stop.set()
    thread.join(60)
    assert not thread.is_alive()
    assert found == []
