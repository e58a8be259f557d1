"""Since when, how often, in which versions each fault occurred: of the history of all runs."""

from __future__ import annotations

import os
import sqlite3
from dataclasses import asdict, dataclass
from typing import Any

from launcher.faults.history import database
from launcher.faults.history.database import HistoryError
from launcher.faults.history.versions import FilesVersion


@dataclass(frozen=True, slots=True, kw_only=True)
class FaultSummary:
    """A fault of a target in all its runs; times are seconds since 1970.

    `times`: how often it was confirmed, in `runs` of the target, `runs_since` of which there were
    without it since the last one. `first_version` is what was run when it was first seen.
    `cause` is the last that was found, `seen` what was seen the last time.
    """

    fault: str
    kind: str | None
    since_s: float
    last_s: float
    times: int
    runs: int
    runs_since: int
    first_version: FilesVersion
    last_version: FilesVersion
    versions: int
    seen: str | None
    cause: str | None
    muted: dict[str, Any] | None = None

    def document(self) -> dict[str, Any]:
        return asdict(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class TargetHistory:
    """The runs of a launch file, and their faults: those of the last run first."""

    target: str
    runs: int
    since_s: float
    faults: tuple[FaultSummary, ...]

    def document(self) -> dict[str, Any]:
        faults = [one.document() for one in self.faults]
        return {
            "target": self.target,
            "runs": self.runs,
            "since_s": self.since_s,
            "faults": faults,
        }


_FAULTS = """
SELECT faults.*, runs.started_s, runs.files_hash, runs.git, runs.target
FROM faults JOIN runs ON runs.id = faults.run WHERE runs.target = ?
ORDER BY faults.confirmed_s
"""
_MUTES = "SELECT fault, reason, until_s FROM mutes WHERE target = ?"


def summaries(folder: str, target: str) -> list[FaultSummary]:
    """The faults of the runs of a target in a log folder; HistoryError if it cannot be read."""
    return [fault for one in histories(folder) if one.target == target for fault in one.faults]


def histories(folder: str) -> list[TargetHistory]:
    """Of all targets, the one that was run last first; [] if there is no history; HistoryError."""
    path = database.path_in(folder)
    if not os.path.exists(path):
        return []
    try:
        with database.reading(path) as opened:
            if not opened.execute("SELECT 1 FROM sqlite_master LIMIT 1").fetchall():
                return []  # it is being made
            starts: dict[str, list[float]] = {}
            query = "SELECT target, started_s FROM runs ORDER BY started_s DESC"
            for target, started_s in opened.execute(query):
                starts.setdefault(target, []).append(started_s)
            return [_target(opened, target, found) for target, found in starts.items()]
    except HistoryError as error:
        raise HistoryError(f"cannot read {path}: {error}") from None


def _target(opened: sqlite3.Connection, target: str, starts_s: list[float]) -> TargetHistory:
    """`starts_s` of its runs, the newest first."""
    rows: dict[str, list[sqlite3.Row]] = {}
    for row in opened.execute(_FAULTS, (target,)):
        rows.setdefault(row["fault"], []).append(row)
    mutes = {row["fault"]: row for row in opened.execute(_MUTES, (target,))}
    faults = [_summary(found, starts_s, mutes.get(fault)) for fault, found in rows.items()]
    faults.sort(key=lambda one: one.last_s, reverse=True)
    return TargetHistory(
        target=target, runs=len(starts_s), since_s=starts_s[-1], faults=tuple(faults)
    )


def _summary(
    rows: list[sqlite3.Row], starts_s: list[float], mute: sqlite3.Row | None
) -> FaultSummary:
    """`rows`: one for each occurrence, in order; the newest of many may be all that is kept."""
    first, last = rows[0], rows[-1]
    counts: dict[str, int] = {}
    for row in rows:
        counts[row["run"]] = max(counts.get(row["run"], 0), row["occurrence"])
    causes = [row["cause"] for row in rows if row["cause"]]
    return FaultSummary(
        fault=first["fault"],
        kind=last["kind"],
        since_s=min(row["first_s"] for row in rows),
        last_s=max(row["last_s"] or row["confirmed_s"] for row in rows),
        times=sum(counts.values()),
        runs=len(counts),
        runs_since=sum(one > last["started_s"] for one in starts_s),
        first_version=FilesVersion(first["files_hash"], first["git"]),
        last_version=FilesVersion(last["files_hash"], last["git"]),
        versions=len({(row["files_hash"], row["git"]) for row in rows}),
        seen=last["seen"],
        cause=causes[-1] if causes else None,
        muted=None if mute is None else {"reason": mute["reason"], "until_s": mute["until_s"]},
    )
