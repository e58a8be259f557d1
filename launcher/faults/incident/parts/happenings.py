"""What happened in an incident, as one list in the order of time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from launcher.base.model.fault_events import FaultConfirmed
from launcher.base.model.run_event import Entry
from launcher.faults.incident.document import IncidentDocument

# What an event is, by its name; others are `other`.
_EVENTS = {
    "ended": "end",
    "member ended": "end",
    "not started": "bad",
    "stuck": "bad",
    "over budget": "bad",
    "not responding": "bad",
    "started": "start",
    "ready": "start",
    "responds": "start",
    "adopted": "start",
    "asked": "asked",
    "signal": "asked",
    "injected": "asked",
    "injection": "asked",
    "files changed": "asked",
    "reloaded": "asked",
}
REPORTED_S = 3.0  # a fault is reported so long after it was confirmed at most
_OF_FAULTS = frozenset({"fault", "fault healed"})  # the faults have these times themselves
KINDS = {
    "bad": "failure",
    "end": "end",
    "start": "start",
    "asked": "request, signal or injection",
    "fault": "fault",
    "healed": "fault healed",
    "cause": "cause",
    "other": "other",
}


@dataclass(frozen=True, slots=True)
class Happening:
    """`kind` is one of KINDS; `about` the process or the fault, empty for the run."""

    at_s: float
    kind: str
    about: str
    text: str


def happenings(incident: IncidentDocument) -> list[Happening]:
    """Events, the lives of faults, and causes; samples are in charts."""
    found = [*_events(incident), *_faults(incident), *_causes(incident)]
    return sorted(found, key=lambda one: one.at_s)


def _events(incident: IncidentDocument) -> Iterator[Happening]:
    for entry in incident.events:
        if not entry.event.is_sample and entry.event.event not in _OF_FAULTS:
            yield Happening(entry.wall_s, kind_of(entry), entry.process or "", entry.event.text)


def kind_of(entry: Entry) -> str:
    if entry.event.is_failure:
        return "bad"
    return _EVENTS.get(entry.event.event, "other")


def _faults(incident: IncidentDocument) -> Iterator[Happening]:
    for fault in incident.faults:
        if fault.first_s is not None and fault.first_s != fault.confirmed_s:
            yield Happening(fault.first_s, "fault", fault.fault, "first seen")
        if fault.confirmed_s is not None:
            seen = _seen_then(fault.fault, fault.confirmed_s, incident)
            text = ": ".join(filter(None, ["confirmed", seen]))
            yield Happening(fault.confirmed_s, "fault", fault.fault, text)
        if fault.healed_s is not None:
            yield Happening(fault.healed_s, "healed", fault.fault, "healed")


def _seen_then(name: str, confirmed_s: float, incident: IncidentDocument) -> str:
    """What was seen when it was confirmed, by the event log; `seen` of a fault is the last."""
    for entry in incident.events:
        event, is_then = entry.event, -0.5 <= entry.wall_s - confirmed_s <= REPORTED_S
        if isinstance(event, FaultConfirmed) and event.fault == name and is_then:
            return event.seen
    return ""


def _causes(incident: IncidentDocument) -> Iterator[Happening]:
    for cause in incident.causes:
        if cause.at_s is not None:
            yield Happening(cause.at_s, "cause", "cause", cause.text)
