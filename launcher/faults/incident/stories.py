"""What a run has to show: its incidents, and snapshots of the flight recorder without one."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass

from launcher.base.text import did_you_mean, several
from launcher.faults.incident import document, from_snapshot
from launcher.faults.incident.document import IncidentDocument, IncidentError
from launcher.faults.incident.run_folder import Report, RunFolder

INCIDENTS, SNAPSHOTS = "incidents", "snapshots"
LAST = "last"
_SUFFIX = ".json"


@dataclass(frozen=True, slots=True)
class IncidentStory:
    """An incident as the list has it; `path` is its file, or the folder of a snapshot."""

    id: str
    path: str
    incident: IncidentDocument

    @property
    def is_snapshot(self) -> bool:
        return self.incident.number == 0


def stories(folder: RunFolder, report: Report) -> list[IncidentStory]:
    """All of a run, the oldest first; `report` gets what could not be read."""
    found = list(_incidents(folder, report))
    known = {os.path.realpath(one.incident.snapshot) for one in found if one.incident.snapshot}
    found += [one for one in _snapshots(folder, report) if os.path.realpath(one.path) not in known]
    return sorted(found, key=lambda one: one.incident.opened_s)


def choose(found: list[IncidentStory], which: str, folder: RunFolder) -> IncidentStory:
    """The one with this id, or whose id begins so; `last` is the newest. IncidentError."""
    if not found:
        raise IncidentError(
            f"run {folder.name} has neither incidents nor snapshots",
            hint="incidents need --expect or --watchful, snapshots --record",
        )
    if which == LAST:
        return found[-1]
    named = [one for one in found if one.id == which] or [
        one for one in found if one.is_snapshot and one.id.startswith(which)
    ]
    if len(named) == 1:
        return named[0]
    ids = [one.id for one in named or found]
    hint = did_you_mean(which, ids) or f"known: {several(ids, 8)}"
    what = "is ambiguous" if named else f"is not one of run {folder.name}"
    raise IncidentError(f"incident '{which}' {what}", hint=hint)


def whole(story: IncidentStory, folder: RunFolder | None) -> IncidentStory:
    """With the topics of the bag of a snapshot, which the list does without."""
    return of_snapshot(story.path, folder) if story.is_snapshot else story


def of_snapshot(path: str, folder: RunFolder | None, *, has_topics: bool = True) -> IncidentStory:
    """The folder of a snapshot, wherever it is; IncidentError."""
    value = from_snapshot.document_of(path, folder, has_topics=has_topics)
    return IncidentStory(os.path.basename(os.path.normpath(path)), path, document.from_value(value))


def _incidents(folder: RunFolder, report: Report) -> Iterator[IncidentStory]:
    for name in _names(folder.file(INCIDENTS)):
        id_, suffix = os.path.splitext(name)
        if suffix == _SUFFIX and id_.isdecimal():
            path = folder.file(INCIDENTS, name)
            try:
                yield IncidentStory(id_, path, document.read(path))
            except IncidentError as error:
                report(error.message)


def _snapshots(folder: RunFolder, report: Report) -> Iterator[IncidentStory]:
    for name in _names(folder.file(SNAPSHOTS)):
        path = folder.file(SNAPSHOTS, name)
        if os.path.isdir(path) and not name.endswith(".part"):
            try:
                yield of_snapshot(path, folder, has_topics=False)
            except IncidentError as error:
                report(error.message)


def _names(path: str) -> list[str]:
    try:
        return sorted(os.listdir(path))
    except OSError:
        return []
