"""Adds to an incident what its document lacks and the folder of its run has."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from launcher.base import strict_json
from launcher.base.model.run_event import Entry
from launcher.base.model.run_events import Resources
from launcher.faults.incident.document import (
    MAX_EVENTS,
    MAX_LINES,
    MAX_POINTS,
    IncidentDocument,
    Point,
    ReportedLine,
)
from launcher.faults.incident.merged_log import merged_lines
from launcher.faults.incident.redaction import document_without_secrets, without_secrets
from launcher.faults.incident.run_folder import RunFolder, entries_of
from launcher.output.logs.run_directory import PLAN

BEFORE_S, AFTER_S = 60.0, 20.0
_MAX_PLAN = 64 * 1024 * 1024


def completed(incident: IncidentDocument, folder: RunFolder | None) -> IncidentDocument:
    """With the run, and with events, samples and lines around the incident if it has none."""
    if folder is None:
        return incident
    known = {**folder.run, **{k: v for k, v in incident.run.items() if v is not None}}
    changes: dict[str, Any] = {"run": known}
    if not incident.versions:
        changes["versions"] = folder.versions
    if not incident.events or not incident.processes:
        entries = [one for one in entries_of(folder.path) if _is_near(one.wall_s, incident)]
        if not incident.events:
            kept = [one for one in entries if not one.event.is_sample]
            changes["events"] = tuple(kept[-MAX_EVENTS:])
        if not incident.processes:
            changes["processes"] = _samples(entries, incident.processes_in_question)
    if not incident.lines:
        changes["lines"] = _lines(folder.path, incident)
    return replace(incident, **changes)


def plan_of(incident: IncidentDocument, folder: RunFolder | None) -> Mapping[str, Any] | None:
    """The plan of the run, or of the snapshot, without secrets."""
    paths = [os.path.join(one, PLAN) for one in (incident.snapshot,) if one]
    paths += [folder.file(PLAN)] if folder is not None else []
    for path in paths:
        with contextlib.suppress(OSError, ValueError):
            if os.path.getsize(path) <= _MAX_PLAN:
                with open(path, "rb") as file:
                    value = document_without_secrets(strict_json.loads(file.read()))
                if isinstance(value, Mapping):
                    return value
    return None


def _is_near(at_s: float, incident: IncidentDocument) -> bool:
    until_s = incident.opened_s if incident.closed_s is None else incident.closed_s
    return incident.opened_s - BEFORE_S <= at_s <= until_s + AFTER_S


def _samples(entries: list[Entry], names: tuple[str, ...]) -> dict[str, tuple[Point, ...]]:
    found: dict[str, list[Point]] = {name: [] for name in names}
    for entry in entries:
        if isinstance(entry.event, Resources):
            for name, one in entry.event.processes.items():
                if name in found:
                    values = (one.cpu_percent, one.rss_bytes)
                    row = tuple(float("nan") if v is None else float(v) for v in values)
                    found[name].append((entry.wall_s, *row))
    return {name: tuple(rows[-MAX_POINTS:]) for name, rows in found.items() if rows}


def _lines(path: str, incident: IncidentDocument) -> tuple[ReportedLine, ...]:
    near = [one for one in merged_lines(path) if _is_near(one.wall_s, incident)]
    return tuple(
        ReportedLine(wall_s=one.wall_s, process=one.process, text=without_secrets(one.text))
        for one in near[-MAX_LINES:]
    )
