"""The document of an incident out of a snapshot of the flight recorder.

A snapshot has no faults of a watched run: those of the document are the processes that died in its
span, and what is known of each from the event log.
"""

from __future__ import annotations

import os
import re
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from launcher.bag.bag_model import BagError
from launcher.bag.reader import Bag
from launcher.bag.snapshot_folder import INDEX
from launcher.base import strict_json
from launcher.base.model.run_event import Entry
from launcher.base.model.run_events import Asked, Resources, Signalled, Started
from launcher.faults.incident.document import MAX_POINTS, IncidentError, label_of
from launcher.faults.incident.merged_log import LoggedLine, merged_lines
from launcher.faults.incident.run_folder import RunFolder, entries_of

MAX_TOPICS = 12
_BEFORE_S = 3.0  # a request or a signal so long before a death may be its cause
_LINES = 20  # of a process that died
_END = re.compile(r"(\d{4}-\d\d-\d\d \d\d:\d\d:\d\d)\.(\d{3})")
_LAST = re.compile(r"\s*[\d.]+  last (/\S+) of (\S+)")
Document = dict[str, Any]


def document_of(path: str, folder: RunFolder | None = None, *, has_topics: bool = True) -> Document:
    """What `document.from_value` reads; number 0. IncidentError if it is no snapshot.

    `folder` is that of the run, if it is known. The times of topics are in the bag, which may be
    large.
    """
    index = _index(path)
    entries = entries_of(path)
    lines = merged_lines(os.path.join(path, "logs"))
    end_s = _end_s(index, path)
    deaths = [entry for entry in entries if entry.event.is_failure]
    reason = _reason(index)
    opened_s = max((one.wall_s for one in deaths if f"{one.process} " in reason), default=end_s)
    faults = [_fault(entry, entries, lines, index) for entry in deaths[::-1]]
    wanted = [topic for one in faults for topic in one["topics"]]
    run = dict(folder.run) if folder else {}
    versions = dict(folder.versions) if folder else {}
    return {
        "format": 1,
        "number": 0,
        "run": run,
        "launcher": versions.pop("launcher", ""),
        "ros": "",
        "title": reason,
        "opened_s": opened_s,
        "closed_s": None,
        "faults": faults,
        "causes": [cause for entry in deaths for cause in _causes(entry, entries)],
        "graphs": {"before": _graph(path), "after": None},
        "topics": _topics(path, wanted) if has_topics else {},
        "processes": _samples(entries, [name for one in faults for name in one["processes"]]),
        "machine": [],
        "lines": [
            {"wall_s": line.wall_s, "process": line.process, "text": line.text}
            for line in lines[-MAX_POINTS:]
        ],
        "events": [entry.item for entry in entries if not entry.event.is_sample],
        "snapshot": path,
        "versions": versions,
    }


def _index(path: str) -> list[str]:
    try:
        with open(os.path.join(path, INDEX), encoding="utf-8", errors="replace") as file:
            return file.read().splitlines()
    except OSError as error:
        reason = error.strerror or str(error)
        hint = "snapshots are in `snapshots` of the log folder of a run with --record"
        raise IncidentError(f"{path} is not a snapshot: {INDEX}: {reason}", hint=hint) from None


def _reason(index: Sequence[str]) -> str:
    reason = next((line[4:].strip() for line in index if line.startswith("why:")), "")
    return reason or "a snapshot without a reason"


def _end_s(index: Sequence[str], path: str) -> float:
    """When the span ends; the index has it in local time."""
    for line in index:
        found = _END.search(line) if line.startswith("end:") else None
        if found is not None:
            local = time.strptime(found[1], "%Y-%m-%d %H:%M:%S")
            return time.mktime(local) + int(found[2]) / 1000
    return os.path.getmtime(os.path.join(path, INDEX))


def _fault(
    entry: Entry, entries: Sequence[Entry], lines: Sequence[LoggedLine], index: Sequence[str]
) -> Document:
    name = entry.process or "a process"
    own = [line for line in lines if line.process == entry.process and line.wall_s <= entry.wall_s]
    label = label_of(name)
    back_s = _return_s(entry, entries)
    published = [found for found in map(_LAST.match, index) if found and found[2] == label]
    return {
        "fault": f"no deaths: {name}",
        "expectation": "no deaths",
        "kind": "death",
        "place": None,
        "state": "active" if back_s is None else "healed",
        "expected": f"{name} runs",
        "seen": entry.event.text,
        "first_s": entry.wall_s,
        "confirmed_s": entry.wall_s,
        "last_s": entry.wall_s,
        "healed_s": back_s,
        "count": 1,
        "lines": [line.text for line in own[-_LINES:]],
        "processes": [entry.process] if entry.process else [],
        "topics": [found[1] for found in published if found[1] != "/rosout"],
        "nodes": [],
    }


def _causes(death: Entry, entries: Sequence[Entry]) -> Iterator[Document]:
    """A request shortly before, else a signal: the event log says who ended a process."""
    before = [
        entry
        for entry in entries
        if entry.process == death.process and 0 <= death.wall_s - entry.wall_s <= _BEFORE_S
    ]
    asked = [entry for entry in before if isinstance(entry.event, Asked)]
    for entry in asked[-1:] or [one for one in before if isinstance(one.event, Signalled)]:
        before_s = death.wall_s - entry.wall_s
        yield {
            "rule": "event log",
            "text": f"{entry.sentence}, {before_s:.2f} s before it ended",
            "at_s": entry.wall_s,
            "about": [entry.process],
        }


def _return_s(death: Entry, entries: Iterable[Entry]) -> float | None:
    """When the process was started again."""
    return next(
        (
            entry.wall_s
            for entry in entries
            if entry.process == death.process
            and isinstance(entry.event, Started)
            and entry.wall_s >= death.wall_s
        ),
        None,
    )


def _graph(path: str) -> Document | None:
    """`graph.json`, if somebody has put one beside the bag."""
    try:
        with open(os.path.join(path, "graph.json"), "rb") as file:
            value = strict_json.loads(file.read())
    except (OSError, ValueError):
        return None
    return value if isinstance(value, dict) else None


def _samples(entries: Iterable[Entry], names: Sequence[str]) -> Document:
    """CPU and memory of the processes that died, or of all if none has."""
    found: dict[str, list[list[float | None]]] = {}
    for entry in entries:
        if isinstance(entry.event, Resources):
            for name, sample in entry.event.processes.items():
                if not names or name in names:
                    row = [entry.wall_s, sample.cpu_percent, sample.rss_bytes]
                    found.setdefault(name, []).append(row)
    return {name: {"samples": rows[-MAX_POINTS:]} for name, rows in found.items()}


def _topics(path: str, wanted: Sequence[str]) -> Document:
    """When the messages of the bag came: of the wanted topics, else of those with the most."""
    try:
        bag = Bag(os.path.join(path, "bag"))
        types = {topic.name: topic.type for topic in bag.topics}
        most = sorted(types, key=lambda name: (name == "/rosout", -bag.extent.counts.get(name, 0)))
        chosen = [name for name in dict.fromkeys(wanted) if name in types] or most
        times = _times(bag, chosen[:MAX_TOPICS])
    except (BagError, OSError):
        return {}
    return {
        name: {"type": types[name], "expected": None, "arrivals": arrivals, "delays": []}
        for name, arrivals in times.items()
    }


def _times(bag: Bag, names: Sequence[str]) -> Mapping[str, list[float]]:
    """The newest times, in seconds."""
    found: dict[str, list[float]] = {name: [] for name in names}
    for name, times_ns in bag.times():
        if name in found:
            found[name] += (one / 1e9 for one in times_ns[-MAX_POINTS:])
            del found[name][:-MAX_POINTS]
    return found
