"""Writes the faults of one run into the history, in a thread: the watcher waits for no disk.

Nothing here raises an error: without a history a run is watched all the same.
"""

from __future__ import annotations

import contextlib
import os
import sqlite3
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from launcher.faults.history import database
from launcher.faults.history.database import HistoryError
from launcher.faults.history.versions import FilesVersion

KEEP_RUNS = 1000  # in one folder
KEEP_S = 90 * 86400.0  # since the last line of a run
KEEP_ROWS = 50_000  # of all runs together, but for the newest run: some 30 MB
KEEP_OCCURRENCES = 100  # of one fault in one run: the first, and the newest
MAX_WAITING = 10_000  # rows that could not be written yet
MAX_TEXT = 2000
RETRY_S = 5.0  # after an error that may pass: a full disk
CLOSE_S = 3.0
# After a transaction: those who wait for the lock look for it again after 0.1 s at most
# (`sqliteDefaultBusyCallback`), so that each of them gets its turn; what comes meanwhile is
# written at once.
PAUSE_S = 0.2
_FAULT_FIELDS = (
    "expectation",
    "kind",
    "place",
    "first_s",
    "confirmed_s",
    "last_s",
    "healed_s",
    "expected",
    "seen",
    "cause",
    "rule",
    "follows",
    "incident",
)
_RUN_FIELDS = (
    "id",
    "target",
    "started_s",
    "ended_s",
    "seen_s",
    "files_hash",
    "git",
    "launcher",
    "log_dir",
)
_SET_RUN = f"INSERT OR REPLACE INTO runs ({', '.join(_RUN_FIELDS)}) VALUES ({', '.join('?' * 9)})"
_SET_FAULT = (
    f"INSERT OR REPLACE INTO faults (run, fault, occurrence, {', '.join(_FAULT_FIELDS)}) "
    f"VALUES ({', '.join('?' * 16)})"
)
_Row = tuple[object, ...]


class FaultHistory:
    """The history in the folder of all runs, as the watcher of one run writes it.

    `note` gets a sentence, once, if it cannot be written; it may be called in another thread.
    """

    def __init__(self, folder: str, note: Callable[[str], object]) -> None:
        self._path = database.path_in(folder)
        self._note = note
        self._has_noted = False
        self._run: dict[str, object] | None = None
        self._waiting: dict[_Row, tuple[str, _Row]] = {}  # key of a row -> statement, values
        self._lock = threading.Condition()
        self._is_closing = self._is_given_up = False
        self._thread: threading.Thread | None = None

    # ---- one run

    def begin_run(
        self,
        *,
        run: str,
        target: str,
        started_s: float,
        version_of: Callable[[], FilesVersion],
        launcher: str,
        log_dir: str | None,
    ) -> None:
        """A run has begun; `run` is its id, `target` its launch file, `launcher` our version.

        `version_of` is called in the thread.
        """
        values = (run, target, started_s, None, started_s, None, None, launcher, log_dir)
        self._run = dict(zip(_RUN_FIELDS, map(_kept, values), strict=True))
        with self._lock:
            self._thread = threading.Thread(target=self._begin, args=(version_of,), daemon=True)
            self._thread.start()
            self._lock.notify()

    def record(self, fault: Mapping[str, Any]) -> None:
        """A fault that has changed, as in docs/reference/faults.md; one that is a suspicion is not
        written.

        One row for each time that it was confirmed, which the newest document replaces.
        """
        if fault.get("confirmed_s") is None or self._run is None:
            return
        occurrence = fault["count"]
        key = (self._run["id"], _kept(fault["fault"]), occurrence)
        values = tuple(_kept(fault.get(name)) for name in _FAULT_FIELDS)
        self._put(key, _SET_FAULT, (*key, *values))
        if occurrence > KEEP_OCCURRENCES:
            old = (*key[:2], occurrence - KEEP_OCCURRENCES)
            which = "run = ? AND fault = ? AND occurrence BETWEEN 2 AND ?"
            self._put((*key[:2], "old"), f"DELETE FROM faults WHERE {which}", old)

    def end_run(self, ended_s: float | None = None) -> None:
        """The run has ended: write what is left, which may take CLOSE_S seconds."""
        if self._run is not None:
            self._run["ended_s"] = time.time() if ended_s is None else ended_s
        with self._lock:
            self._is_closing = True
            self._lock.notify()
        if self._thread is not None:
            self._thread.join(CLOSE_S)
            if self._thread.is_alive():
                self._failed(TimeoutError(f"not written within {CLOSE_S:g} s"))

    # ---- mutes, which hold for all runs of a target

    def mutes_of(self, target: str, now_s: float | None = None) -> dict[str, dict[str, Any]]:
        """`reason` and `until_s` of each muted fault that are not over."""
        now_s = time.time() if now_s is None else now_s
        which = "target = ? AND (until_s IS NULL OR until_s > ?)"
        query = f"SELECT fault, reason, until_s FROM mutes WHERE {which}"
        if not os.path.exists(self._path):
            return {}
        try:
            with database.reading(self._path) as opened:
                rows = opened.execute(query, (_kept(target), now_s)).fetchall()
        except HistoryError as error:
            if "no such table" not in str(error):  # another run is just making it
                self._failed(error)
            return {}
        return {fault: {"reason": reason, "until_s": until_s} for fault, reason, until_s in rows}

    def set_mute(
        self,
        target: str,
        fault: str,
        reason: str | None,
        until_s: float | None,
        since_s: float | None = None,
    ) -> None:
        """Mute it until then, or for good."""
        since_s = time.time() if since_s is None else since_s
        row = tuple(map(_kept, (target, fault, reason, since_s, until_s)))
        self._put(("mute", *row[:2]), "INSERT OR REPLACE INTO mutes VALUES (?, ?, ?, ?, ?)", row)

    def clear_mute(self, target: str, fault: str) -> None:
        which = (_kept(target), _kept(fault))
        self._put(("mute", *which), "DELETE FROM mutes WHERE target = ? AND fault = ?", which)

    # ---- writing

    def _put(self, key: _Row, statement: str, values: _Row) -> None:
        with self._lock:
            self._waiting.pop(key, None)  # the newest is the last
            if self._is_given_up or len(self._waiting) >= MAX_WAITING:
                return
            self._waiting[key] = (statement, values)
            self._lock.notify()

    def _begin(self, version_of: Callable[[], FilesVersion]) -> None:
        """The thread."""
        assert self._run is not None
        version = version_of()
        self._run.update(files_hash=_kept(version.files_hash), git=_kept(version.git))
        self._write_all()

    def _write_all(self) -> None:
        """Write what waits, in one transaction for what has come meanwhile."""
        opened: sqlite3.Connection | None = None
        is_last = False
        try:
            while not is_last:
                is_last = self._is_closing
                try:
                    opened = opened or self._begun()
                    self._write(opened)
                except sqlite3.OperationalError as error:  # a full disk, a lock: that may pass
                    self._failed(error)
                    self._rest(RETRY_S)
                    continue
                if not is_last:
                    self._rest(PAUSE_S)
                    self._rest(None)
        except (sqlite3.Error, HistoryError) as error:
            self._failed(error)
            self._give_up()
        finally:
            if opened is not None:
                with contextlib.suppress(sqlite3.Error):
                    opened.close()

    def _rest(self, timeout_s: float | None) -> None:
        """So long, or else until something waits; never after the end of the run."""
        with self._lock:
            if timeout_s is None:
                self._lock.wait_for(lambda: self._waiting or self._is_closing)
            else:
                self._lock.wait_for(lambda: self._is_closing, timeout_s)

    def _begun(self) -> sqlite3.Connection:
        opened = database.open_to_write(self._path)
        with contextlib.suppress(sqlite3.OperationalError):  # is not urgent
            _prune(opened, time.time())
        return opened

    def _write(self, opened: sqlite3.Connection) -> None:
        with self._lock:
            batch, self._waiting = self._waiting, {}
        run = {**(self._run or {}), "seen_s": time.time()}
        try:
            opened.execute("BEGIN IMMEDIATE")
            # Again and again, since another run may have pruned it.
            opened.execute(_SET_RUN, tuple(run[name] for name in _RUN_FIELDS))
            for statement, values in batch.values():
                opened.execute(statement, values)
            opened.execute("COMMIT")
        except sqlite3.Error:
            with self._lock:
                for key in self._waiting:
                    batch.pop(key, None)
                self._waiting = batch | self._waiting
            with contextlib.suppress(sqlite3.Error):
                opened.execute("ROLLBACK")
            raise

    def _give_up(self) -> None:
        with self._lock:
            self._is_given_up = True
            self._waiting = {}

    def _failed(self, error: Exception) -> None:
        if not self._has_noted:
            self._has_noted = True
            self._note(f"the history of faults is not kept: {self._path}: {error}")


def _prune(opened: sqlite3.Connection, now_s: float) -> None:
    """Remove old runs, and what belongs to none."""
    opened.execute("BEGIN IMMEDIATE")
    try:
        opened.execute("DELETE FROM runs WHERE seen_s < ?", (now_s - KEEP_S,))
        newest = "SELECT id FROM runs ORDER BY seen_s DESC LIMIT ?"
        opened.execute(f"DELETE FROM runs WHERE id NOT IN ({newest})", (KEEP_RUNS,))
        _prune_largest(opened)
        opened.execute("DELETE FROM faults WHERE run NOT IN (SELECT id FROM runs)")
        opened.execute("DELETE FROM mutes WHERE until_s < ?", (now_s,))
        opened.execute("COMMIT")
    except sqlite3.Error:
        with contextlib.suppress(sqlite3.Error):
            opened.execute("ROLLBACK")
        raise


def _prune_largest(opened: sqlite3.Connection) -> None:
    """Remove the oldest runs if there are too many rows: a fault may come and go all day."""
    query = (
        "SELECT runs.id, (SELECT count(*) FROM faults WHERE faults.run = runs.id) FROM runs "
        "ORDER BY seen_s DESC"
    )
    rows = 0
    for run, faults in opened.execute(query).fetchall():
        if rows + faults > KEEP_ROWS and rows > 0:
            opened.execute("DELETE FROM runs WHERE id = ?", (run,))
        rows += faults


def _kept(value: object) -> object:
    """A value as SQLite takes it: no endless texts, no half characters."""
    if isinstance(value, str):
        return value[:MAX_TEXT].encode("utf-8", "replace").decode("utf-8")
    if isinstance(value, int) and abs(value) >= 2**63:
        return float(value) if abs(value) < 2**1000 else None
    return value if value is None or isinstance(value, int | float) else str(value)[:MAX_TEXT]
