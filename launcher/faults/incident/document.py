"""The document of an incident: `incidents/NUMBER.json` in the folder of a run.

A reader meets files of other versions and files that are cut short: a field that is missing has its
default, and one of a wrong type as well, which `problems` then names. Times are in seconds since
1970.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from launcher.base import strict_json, text_file
from launcher.base.errors import LauncherError
from launcher.base.model.event_entries import entry_of
from launcher.base.model.run_event import Entry
from launcher.faults.incident.fields import MAX_NAME, DocumentFields
from launcher.faults.incident.redaction import document_without_secrets

FORMAT = 1
MAX_BYTES = 64 * 1024 * 1024
MAX_POINTS = 2000  # of a series
MAX_LINES = 4000
MAX_EVENTS = 4000
MAX_FAULTS = 200

Point = tuple[float, ...]


class IncidentError(LauncherError):
    """There is no such incident, or its file cannot be used; exit code 1."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportedFault:
    """One fault of the incident; `follows` is the id of another one."""

    fault: str
    kind: str = ""
    place: str | None = None
    state: str = ""
    expected: str = ""
    seen: str = ""
    first_s: float | None = None
    confirmed_s: float | None = None
    last_s: float | None = None
    healed_s: float | None = None
    count: int = 0
    lines: tuple[str, ...] = ()
    message: Any = None
    processes: tuple[str, ...] = ()
    topics: tuple[str, ...] = ()
    nodes: tuple[str, ...] = ()
    cause: str | None = None
    rule: str | None = None
    follows: str | None = None
    notes: tuple[str, ...] = ()  # acknowledged or muted, with the reason


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportedTopic:
    """When messages of a topic in question came, and how late: (time, seconds).

    `fitting`: when those came that satisfy the conditions of a fault, by its id. Not `is_watched`:
    nobody has looked when messages came.
    """

    type: str = ""
    expected: str | None = None
    is_watched: bool = True
    arrivals: tuple[float, ...] = ()
    fitting: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    delays: tuple[Point, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportedCause:
    """What a rule has found."""

    rule: str
    text: str
    at_s: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportedLine:
    """A line of the log; `process` is None for the launcher."""

    wall_s: float
    process: str | None
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class IncidentDocument:
    """All of it; `problems` says what could not be read, and `raw` is the JSON without secrets.

    `processes` has samples (time, CPU in percent of a core, RSS in bytes or NaN), since the USS is
    measured every 10 s only; `machine` rows as the design of the document names them, with NaN for
    what is unknown.
    """

    number: int
    title: str
    opened_s: float
    closed_s: float | None = None
    run: Mapping[str, Any] = field(default_factory=dict)
    launcher: str = ""
    ros: str = ""
    faults: tuple[ReportedFault, ...] = ()
    causes: tuple[ReportedCause, ...] = ()
    graphs: Mapping[str, Any] = field(default_factory=dict)
    topics: Mapping[str, ReportedTopic] = field(default_factory=dict)
    processes: Mapping[str, tuple[Point, ...]] = field(default_factory=dict)
    machine: tuple[Point, ...] = ()
    lines: tuple[ReportedLine, ...] = ()
    events: tuple[Entry, ...] = ()
    parameters: Any = None
    snapshot: str | None = None
    versions: Mapping[str, Any] = field(default_factory=dict)
    problems: tuple[str, ...] = ()
    raw: Mapping[str, Any] = field(default_factory=dict, repr=False)

    @property
    def processes_in_question(self) -> tuple[str, ...]:
        """Those of the faults, then those with samples."""
        named = (name for fault in self.faults for name in fault.processes)
        return tuple(dict.fromkeys([*named, *self.processes]))


def read(path: str) -> IncidentDocument:
    """The incident in a file; IncidentError."""
    try:
        value = strict_json.loads(text_file.read(path, limit=MAX_BYTES))
    except OSError as error:
        raise IncidentError(f"cannot read {path}: {error.strerror or error}") from None
    except ValueError as error:
        raise IncidentError(f"{path} is not the document of an incident: {error}") from None
    try:
        return from_value(value)
    except IncidentError as error:
        raise IncidentError(f"{path}: {error.message}") from None


def from_value(value: object) -> IncidentDocument:
    """The incident that this JSON value is; IncidentError if it is no object at all."""
    if not isinstance(value, Mapping):
        raise IncidentError("it is not a JSON object")
    raw = document_without_secrets(value)
    problems: list[str] = []
    doc = DocumentFields(raw, "", problems)
    _check_format(doc)
    faults = tuple(_fault(one) for one in doc.objects("faults", MAX_FAULTS))
    first_s = min((one.first_s for one in faults if one.first_s is not None), default=0.0)
    opened_s = doc.time("opened_s")
    events = [_entry(one) for one in doc.items("events", MAX_EVENTS)]
    if None in events:
        problems.append(
            f"events: {events.count(None)} of {len(events)} are no entries of an event log"
        )
    return IncidentDocument(
        number=doc.whole("number", 0),
        title=_title_of(doc.text("title"), faults),
        opened_s=first_s if opened_s is None else opened_s,
        closed_s=doc.time("closed_s"),
        run=doc.mapping("run"),
        launcher=doc.text("launcher"),
        ros=doc.text("ros"),
        faults=faults,
        causes=tuple(_cause(one) for one in doc.objects("causes", MAX_FAULTS)),
        graphs=doc.mapping("graphs"),
        topics={name: _topic(one) for name, one in doc.children("topics")},
        processes={
            name: one.points("samples", 3, MAX_POINTS) for name, one in doc.children("processes")
        },
        machine=doc.points("machine", 6, MAX_POINTS),
        lines=tuple(_line(one) for one in doc.objects("lines", MAX_LINES)),
        events=tuple(one for one in events if one is not None),
        parameters=raw.get("parameters"),
        snapshot=doc.optional("snapshot"),
        versions=doc.mapping("versions"),
        problems=tuple(problems),
        raw=raw,
    )


def _check_format(doc: DocumentFields) -> None:
    number = doc.whole("format", FORMAT)
    if number > FORMAT:
        text = f"format {number} is newer than {FORMAT}: what is new in it is not shown"
        doc.problems.append(text)


def _entry(value: object) -> Entry | None:
    """An entry of the event log; where its monotonic time is left out, it is 0."""
    return entry_of({"monotonic_s": 0.0, **value} if isinstance(value, Mapping) else value)


def _title_of(given: str, faults: tuple[ReportedFault, ...]) -> str:
    """The title; where that is only what was seen, with the fault."""
    if not faults:
        return given or "An incident without a title"
    root = faults[0]
    if given not in ("", root.seen):
        return given
    return root.cause or ": ".join(filter(None, [root.fault, root.seen]))


def _fault(doc: DocumentFields) -> ReportedFault:
    return ReportedFault(
        fault=doc.text("fault") or doc.text("expectation") or "a fault without a name",
        kind=doc.text("kind"),
        place=doc.optional("place"),
        state=doc.text("state"),
        expected=doc.text("expected"),
        seen=doc.text("seen"),
        first_s=doc.time("first_s"),
        confirmed_s=doc.time("confirmed_s"),
        last_s=doc.time("last_s"),
        healed_s=doc.time("healed_s"),
        count=doc.whole("count", 0),
        lines=doc.texts("lines"),
        message=doc.value.get("message"),
        processes=doc.texts("processes"),
        topics=doc.texts("topics"),
        nodes=doc.texts("nodes"),
        cause=doc.optional("cause"),
        rule=doc.optional("rule"),
        follows=doc.optional("follows"),
        notes=tuple(_notes(doc)),
    )


def _notes(doc: DocumentFields) -> Iterator[str]:
    """What a user has decided, and why."""
    for key in ("acknowledged", "muted"):
        if isinstance(doc.value.get(key), Mapping):
            about = DocumentFields(doc.value[key], f"{doc.place}.{key}", doc.problems)
            yield ": ".join(filter(None, [key, about.text("reason")]))


def label_of(process: str) -> str:
    """`robot_1` of `robot_1-3`: the name in the launch file, and as a rule that of its node."""
    return process.rpartition("-")[0] or process


def _cause(doc: DocumentFields) -> ReportedCause:
    return ReportedCause(rule=doc.text("rule"), text=doc.text("text"), at_s=doc.time("at_s"))


def _topic(doc: DocumentFields) -> ReportedTopic:
    given = doc.mapping("fitting")
    fitting = DocumentFields(given, f"{doc.place}.fitting", doc.problems)
    return ReportedTopic(
        type=doc.text("type"),
        expected=doc.optional("expected"),
        is_watched=doc.value.get("arrivals") is not None,
        arrivals=doc.times("arrivals", MAX_POINTS),
        fitting={str(name)[:MAX_NAME]: fitting.times(name, MAX_POINTS) for name in given},
        delays=doc.points("delays", 2, MAX_POINTS),
    )


def _line(doc: DocumentFields) -> ReportedLine:
    return ReportedLine(
        wall_s=doc.time("wall_s") or 0.0, process=doc.optional("process"), text=doc.text("text")
    )
