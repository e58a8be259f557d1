"""The file of the history: its tables, and how it is opened.

It has a write-ahead log: a run then waits for no disk when it writes, only where the log is moved
into the file (every 1000 pages, and at the end); a reader and a writer do not wait for each other;
and a power cut costs at most the last seconds, not the file, as `synchronous=OFF` could.
"""

from __future__ import annotations

import contextlib
import os
import sqlite3
import time
from collections.abc import Iterator
from urllib.parse import quote

FILE = "faults.sqlite"
SCHEMA_VERSION = 1
APPLICATION = 0x4C46_4C54  # "LFLT", in the head of the file
BUSY_S = 3.0  # how long another run may be writing
_TRIES = 20  # to change the journal, for which SQLite does not wait
_PAUSE_S = 0.05
_TABLES = """
CREATE TABLE runs (
    id TEXT PRIMARY KEY, target TEXT NOT NULL, started_s REAL NOT NULL, ended_s REAL,
    seen_s REAL NOT NULL, files_hash TEXT, git TEXT, launcher TEXT, log_dir TEXT
) WITHOUT ROWID;
CREATE INDEX runs_of_target ON runs (target, started_s);
CREATE TABLE faults (
    run TEXT NOT NULL, fault TEXT NOT NULL, occurrence INTEGER NOT NULL,
    expectation TEXT, kind TEXT, place TEXT,
    first_s REAL NOT NULL, confirmed_s REAL NOT NULL, last_s REAL, healed_s REAL,
    expected TEXT, seen TEXT, cause TEXT, rule TEXT, follows TEXT, incident INTEGER,
    PRIMARY KEY (run, fault, occurrence)
) WITHOUT ROWID;
CREATE TABLE mutes (
    target TEXT NOT NULL, fault TEXT NOT NULL, reason TEXT, since_s REAL NOT NULL, until_s REAL,
    PRIMARY KEY (target, fault)
) WITHOUT ROWID;
"""


class HistoryError(Exception):
    """The file is not usable as it is; the message says why, for users."""


def path_in(folder: str) -> str:
    """Where the history of the runs in this folder is."""
    return os.path.join(folder, FILE)


def open_to_write(path: str) -> sqlite3.Connection:
    """Open it, made if there is none; HistoryError, sqlite3.Error."""
    database = sqlite3.connect(path, timeout=BUSY_S, isolation_level=None)
    try:
        if _version(database) < SCHEMA_VERSION:
            _make(database)
        _use_log(database)
        database.execute("PRAGMA synchronous=NORMAL")
        database.execute("PRAGMA journal_size_limit=1000000")
    except BaseException:
        database.close()
        raise
    return database


@contextlib.contextmanager
def reading(path: str) -> Iterator[sqlite3.Connection]:
    """Open an existing one, whose rows have names; HistoryError, also if it cannot be read."""
    try:
        with contextlib.closing(_opened_to_read(path)) as opened:
            opened.row_factory = sqlite3.Row
            yield opened
    except sqlite3.Error as error:
        raise HistoryError(str(error)) from None


def _opened_to_read(path: str) -> sqlite3.Connection:
    try:
        return _opened(f"file:{quote(path)}?mode=ro")
    except sqlite3.OperationalError:
        # A write-ahead log needs a file beside it, which a read-only disk refuses. Without a log
        # nobody is writing.
        if not os.path.exists(path) or os.path.exists(f"{path}-wal"):
            raise
        return _opened(f"file:{quote(path)}?mode=ro&immutable=1")


def _opened(address: str) -> sqlite3.Connection:
    database = sqlite3.connect(address, timeout=BUSY_S, isolation_level=None, uri=True)
    try:
        _version(database)
    except BaseException:
        database.close()
        raise
    return database


def _version(database: sqlite3.Connection) -> int:
    """Version of the tables, 0 if there are none; HistoryError if this is not a history of ours."""
    (version,) = database.execute("PRAGMA user_version").fetchone()
    (application,) = database.execute("PRAGMA application_id").fetchone()
    if application == 0 and version == 0:
        (tables,) = database.execute("SELECT count(*) FROM sqlite_master").fetchone()
        if tables == 0:
            return 0
    if application != APPLICATION:
        raise HistoryError("it is a database of another program")
    if version > SCHEMA_VERSION:
        raise HistoryError(f"a newer launcher has written it (version {version})")
    return int(version)


def _make(database: sqlite3.Connection) -> None:
    """The tables, if no other run makes them at the same time."""
    database.execute("BEGIN IMMEDIATE")
    try:
        if _version(database) == 0:
            for statement in _TABLES.split(";\n"):
                database.execute(statement)
            database.execute(f"PRAGMA application_id={APPLICATION}")
            database.execute(f"PRAGMA user_version={SCHEMA_VERSION}")
        database.execute("COMMIT")
    except BaseException:
        with contextlib.suppress(sqlite3.Error):
            database.execute("ROLLBACK")
        raise


def _use_log(database: sqlite3.Connection) -> None:
    for attempt in range(_TRIES):
        try:
            database.execute("PRAGMA journal_mode=WAL")
        except sqlite3.OperationalError:
            if attempt == _TRIES - 1:
                raise
            time.sleep(_PAUSE_S)
        else:
            return
