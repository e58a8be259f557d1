"""The processes and faults of a run as levels, messages and values of /diagnostics."""

from __future__ import annotations

import enum
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from launcher.base.model.fault_events import with_cause
from launcher.base.text import count
from launcher.control.answer_lines import unreachable
from launcher.control.fault_texts import clock

YOUNG_S = 10.0  # a restarted process is shown as WARN for this time

Row = Mapping[str, Any]
Fault = Mapping[str, Any]  # docs/reference/faults.md


class DiagnosticLevel(enum.IntEnum):
    """As diagnostic_msgs/DiagnosticStatus has them."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Status:
    """One line of a monitor, with the values behind it."""

    name: str
    level: DiagnosticLevel
    message: str
    values: tuple[tuple[str, str], ...] = ()


def statuses(
    rows: Iterable[Row], run: Mapping[str, Any], node: str, faults: Iterable[Fault] = ()
) -> list[Status]:
    """The run itself, then each process and fault, for rqt_robot_monitor and Foxglove.

    `node` comes before their names, so that the runs of a domain differ. A fault that has healed
    stays, as OK: monitors show an entry that is missing as stale. Muted ones, and those that were
    never confirmed, are left out.
    """
    rows = list(rows)
    found = [_of_process(row, node) for row in rows]
    running = sum(row["state"] == "RUNNING" for row in rows)
    of_faults = [_of_fault(one, node) for one in faults if one["count"] and not one["muted"]]
    return [_of_run(found, of_faults, running, run, node), *found, *of_faults]


def all_stale(before: Iterable[Status], why: str) -> list[Status]:
    """The same entries when their state is unknown."""
    return [
        Status(name=one.name, level=DiagnosticLevel.STALE, message=why, values=one.values)
        for one in before
    ]


def _of_run(
    processes: list[Status],
    faults: list[Status],
    running: int,
    run: Mapping[str, Any],
    node: str,
) -> Status:
    bad, active = (
        [one for one in those if one.level in (DiagnosticLevel.WARN, DiagnosticLevel.ERROR)]
        for those in (processes, faults)
    )
    names = ", ".join(one.name.partition(": ")[2] for one in bad)
    summary = f"{running} of {count(len(processes), 'process')} running"
    if active:
        summary += f", {count(len(active), 'fault')}"
    return Status(
        name=f"{node}: run",
        level=max((one.level for one in (*bad, *active)), default=DiagnosticLevel.OK),
        message=f"{summary}; see {names}" if bad else summary,
        values=tuple(
            (name, str(run[name]))
            for name in ("id", "pid", "target", "log_dir", "domain_id")
            if run.get(name) is not None
        ),
    )


def _of_fault(fault: Fault, node: str) -> Status:
    level, message = DiagnosticLevel.ERROR, with_cause(fault["seen"], fault["cause"])
    if fault["state"] != "active":
        level, message = DiagnosticLevel.OK, "healed"
    elif fault["acknowledged"]:
        level = DiagnosticLevel.WARN
    values = {
        "expected": fault["expected"],
        "since": clock(fault["first_s"]),
        "how often": fault["count"],
        "follows": fault["follows"],
        "processes": ", ".join(fault["processes"]) or None,
        "topics": ", ".join(fault["topics"]) or None,
        "nodes": ", ".join(fault["nodes"]) or None,
        "acknowledged": (fault["acknowledged"] or {}).get("reason"),
        "place": fault["place"],
    }
    return Status(
        name=f"{node}: fault {fault['fault']}",
        level=level,
        message=message,
        values=_texts(values),
    )


def _of_process(row: Row, node: str) -> Status:
    level, message = _judged(row)
    name = f"{node}: {row['name']}"
    return Status(name=name, level=level, message=message, values=_values(row))


def _judged(row: Row) -> tuple[DiagnosticLevel, str]:
    last = row["last_exit"]
    end = "" if last is None else last["text"]
    restarts = row["restarts"]
    if unreachable(row):
        return DiagnosticLevel.STALE, f"{row['state'].lower()}, {unreachable(row)}"
    match row["state"]:
        case "RUNNING" if row["paused"]:
            return DiagnosticLevel.WARN, "paused"
        case "RUNNING" if restarts and (row["uptime_s"] or 0.0) < YOUNG_S:
            return DiagnosticLevel.WARN, f"restarted ({restarts}) after {end or 'its end'}"
        case "RUNNING" | "STARTING" | "STOPPING":
            return DiagnosticLevel.OK, row["state"].lower()
        case "BACKOFF":
            return DiagnosticLevel.WARN, f"waiting to restart after {end or 'its end'}"
        case "STOPPED" if last is None:
            return DiagnosticLevel.STALE, "not started"
        case "STOPPED" if not last["asked"] and last["returncode"]:
            return DiagnosticLevel.ERROR, f"crashed when it was stopped: {end}"
        case "STOPPED":
            return DiagnosticLevel.STALE, "stopped by request"
        case "EXITED" if last is None or last["asked"] or last["returncode"] == 0:
            return DiagnosticLevel.OK, "finished"
        case "EXITED":
            return DiagnosticLevel.ERROR, f"exited unexpectedly: {end}"
        case _:
            return DiagnosticLevel.ERROR, f"failed: {end or 'could not be started'}"


def _values(row: Row) -> tuple[tuple[str, str], ...]:
    last = row["last_exit"]
    values = {
        "host": row.get("host"),
        "state": row["state"],
        "pid": row["pid"],
        "nodes": ", ".join(row["node_names"]) or None,
        "uptime (s)": _rounded(row["uptime_s"], 1, 1),
        "restarts": row["restarts"],
        "CPU (%)": _rounded(row["cpu_percent"], 1, 1),
        "memory, USS (MB)": _rounded(row["uss_bytes"], 1e-6, 1),
        "threads": row["threads"],
        "open files": row["fds"],
        "last exit": None if last is None else last["text"],
    }
    return _texts(values)


def _texts(values: Mapping[str, object]) -> tuple[tuple[str, str], ...]:
    """Those that are known."""
    return tuple((name, str(value)) for name, value in values.items() if value is not None)


def _rounded(value: float | None, factor: float, digits: int) -> float | None:
    return None if value is None else round(value * factor, digits)


def service_names(rows: Iterable[Row]) -> dict[str, str]:
    """Process -> its name in the names of services: its label if that is unique.

    Characters other than letters and digits become underscores.
    """
    rows = list(rows)
    labels = [_ros_name(row["label"]) for row in rows]
    return {
        row["name"]: label if labels.count(label) == 1 else _ros_name(row["name"])
        for row, label in zip(rows, labels, strict=True)
    }


def _ros_name(word: str) -> str:
    plain = re.sub(r"[^A-Za-z0-9]+", "_", word).strip("_") or "process"
    return f"p{plain}" if plain[0].isdigit() else plain
