"""Writes incidents into the folder of a run: `incidents/NUMBER.json`, docs/reference/faults.md."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from launcher.base import strict_json
from launcher.base.model.run_event import fields_of
from launcher.base.model.run_events import SnapshotWritten
from launcher.faults.causes.grouping import Incident
from launcher.faults.model.fault import Fault
from launcher.faults.watcher.machine_facts import MachineSample
from launcher.faults.watcher.story import KEEP_S, Story, TopicArrivals
from launcher.smoke.observe.facts import LogLine, ProcessEvent

FOLDER = "incidents"
FORMAT = 1
BEFORE_S, AFTER_S = 60.0, 30.0  # of the incident, that it shows
AGAIN_S = 5.0  # an incident that goes on is written again after this, and when it is over
MOST_LINES = 2000
MOST_TIMES = 2000  # of a topic
GRAPH_BEFORE_S = 0.3  # the last graph of before is so old at least
WallOf = Callable[[float], float]


class IncidentFiles:
    """`head` has the fields about the run. What cannot be written is reported once by `note`."""

    def __init__(
        self,
        run_folder: str | None,
        head: Mapping[str, Any],
        wall_of: WallOf,
        note: Callable[[str], object],
    ) -> None:
        self._folder = None if run_folder is None else Path(run_folder, FOLDER)
        self._head = head
        self._wall_of = wall_of
        self._note = note
        self._has_failed = False
        self._written: set[int] = set()
        self._again: dict[int, float] = {}
        self._before: dict[int, dict[str, Any] | None] = {}  # the graph

    def opened(self, incident: Incident, story: Story) -> None:
        """It is new, or has changed."""
        if incident.number not in self._before:
            self._before[incident.number] = _graph_before(incident.opened_s, story)
        self._again[incident.number] = story.now_s + AGAIN_S
        self._write(incident, story)

    def refresh(self, incidents: Iterable[Incident], story: Story) -> None:
        """Write those that are due; remove those that were joined with others, or are old."""
        known = {one.number: one for one in incidents}
        for number in [*self._before]:
            closed_s = known[number].closed_s if number in known else story.now_s - KEEP_S
            if closed_s is not None and story.now_s - closed_s >= KEEP_S:
                del self._before[number]
        for number, due_s in tuple(self._again.items()):
            if number in known and story.now_s >= due_s:
                del self._again[number]
                self._write(known[number], story)
        for number in self._written - known.keys():
            self._written.remove(number)
            self._again.pop(number, None)
            if self._folder is not None:
                with contextlib.suppress(OSError):
                    os.unlink(self._folder / f"{number}.json")

    def closed(self, incident: Incident, story: Story) -> None:
        self._again.pop(incident.number, None)
        self._write(incident, story)

    def _write(self, incident: Incident, story: Story) -> None:
        if self._folder is None:
            return
        path = self._folder / f"{incident.number}.json"
        text = strict_json.packed(self.document(incident, story), default=str)
        part = path.with_suffix(".part")
        try:
            self._folder.mkdir(exist_ok=True)
            part.write_text(text, encoding="utf-8")
            part.replace(path)
        except OSError as error:
            with contextlib.suppress(OSError):
                part.unlink()
            if not self._has_failed:
                self._has_failed = True
                self._note(f"cannot write {path}: {error.strerror or error}")
            return
        self._written.add(incident.number)

    def document(self, incident: Incident, story: Story) -> dict[str, Any]:
        wall, (from_s, to_s) = self._wall_of, _span(incident, story)
        processes = {name for fault in incident.faults for name in fault.finding.processes}
        about: dict[str, list[Fault]] = {}
        for fault in incident.faults:
            for topic in fault.finding.topics:
                about.setdefault(topic, []).append(fault)
        events = [one for one in story.events if from_s <= one.at_s <= to_s]
        return {
            "format": FORMAT,
            "number": incident.number,
            **self._head,
            "title": incident.title,
            "opened_s": wall(incident.opened_s),
            "closed_s": None if incident.closed_s is None else wall(incident.closed_s),
            "faults": [fault.document(wall) for fault in incident.faults],
            "causes": [
                {"rule": c.rule, "text": c.text, "at_s": wall(c.at_s), "about": sorted(c.about)}
                for c in incident.causes
            ],
            "graphs": {
                "before": self._before.get(incident.number),
                "after": story.document or None,
            },
            "topics": {
                topic: _traffic(topic, about[topic], story, from_s, wall) for topic in sorted(about)
            },
            "processes": {
                name: {"samples": _samples(name, story, from_s, wall)} for name in sorted(processes)
            },
            "machine": _machine([one for one in story.machine if one.at_s >= from_s], wall),
            "lines": _lines([one for one in story.lines if from_s <= one.at_s <= to_s], wall),
            "events": [_event(one, wall) for one in events if not one.event.is_sample],
            "snapshot": _snapshot(one for one in events if one.at_s >= incident.opened_s),
        }


def first_number(run_folder: str | None) -> int:
    """The number of the next incident of a run, which an earlier watcher may have counted."""
    names = [] if run_folder is None else Path(run_folder, FOLDER).glob("*.json")
    return 1 + max((int(one.stem) for one in names if one.stem.isdecimal()), default=0)


def _graph_before(opened_s: float, story: Story) -> dict[str, Any] | None:
    found = [document for at_s, document in story.graphs if at_s < opened_s - GRAPH_BEFORE_S]
    return found[-1] if found else None


def _span(incident: Incident, story: Story) -> tuple[float, float]:
    """From some time before to some time after."""
    end_s = story.now_s if incident.closed_s is None else incident.closed_s
    return incident.opened_s - BEFORE_S, end_s + AFTER_S


def _traffic(
    topic: str, faults: Sequence[Fault], story: Story, from_s: float, wall: WallOf
) -> dict[str, Any]:
    """`arrivals` is None for a topic that no expectation needs the messages of."""
    names = {one.origin.expectation: one.id for one in faults}
    fitting = {names[n]: times for n, times in story.fitting.items() if n in names}
    known = story.arrivals.get(topic) or story.received.get(topic)
    is_watched = known is not None or bool(fitting)
    known = known or TopicArrivals()
    delays = [[round(wall(a), 4), round(s, 6)] for a, s in known.delays if a >= from_s]
    types = [end.type for end in story.endpoints(topic)]
    return {
        "type": types[0] if types else None,
        "expected": faults[-1].origin.expected,
        "arrivals": _times(known.received, from_s, wall) if is_watched else None,
        "fitting": {name: _times(times, from_s, wall) for name, times in fitting.items()},
        "delays": delays[-MOST_TIMES:],
    }


def _times(times: Iterable[float], from_s: float, wall: WallOf) -> list[float]:
    return [round(wall(at_s), 4) for at_s in times if at_s >= from_s][-MOST_TIMES:]


def _samples(name: str, story: Story, from_s: float, wall: WallOf) -> list[list[Any]]:
    return [
        [round(wall(at_s), 2), cpu, rss]
        for at_s, cpu, rss in story.samples.get(name, ())
        if at_s >= from_s
    ]


def _machine(samples: Sequence[MachineSample], wall: WallOf) -> list[list[Any]]:
    """With how far the clock was set since the first one."""
    return [
        [
            round(wall(one.at_s), 2),
            *(_percent(one.pressure.get(name)) for name in ("cpu", "memory", "io")),
            one.free_bytes,
            round(one.clock_s - samples[0].clock_s, 3),
        ]
        for one in samples
    ]


def _lines(lines: Sequence[LogLine], wall: WallOf) -> list[dict[str, Any]]:
    """The last ones."""
    return [
        {"wall_s": wall(line.at_s), "process": line.process, "text": line.text}
        for line in lines[-MOST_LINES:]
    ]


def _percent(share: float | None) -> float | None:
    return None if share is None else round(100 * share, 1)


def _event(one: ProcessEvent[Any], wall: WallOf) -> dict[str, Any]:
    """As an entry of the event log has it."""
    subject = {"process": one.process, "host": one.host}
    return {
        "wall_s": round(wall(one.at_s), 4),
        "event": one.kind,
        **{name: value for name, value in subject.items() if value is not None},
        **fields_of(one.event),
    }


def _snapshot(events: Iterable[ProcessEvent[Any]]) -> str | None:
    """The last snapshot of the flight recorder."""
    found = [one.event.path for one in events if isinstance(one.event, SnapshotWritten)]
    return found[-1] if found else None
