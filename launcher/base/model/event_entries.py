"""Entries of the event log: what a line of `events.jsonl`, or an item of `events`, holds.

A reader meets lines that are cut short, and entries of other versions: what cannot be read as its
type says is an `UnknownEvent`, and what is no entry at all is None.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Mapping

# Their types are in TYPES.
from launcher.base.model import fault_events, injection_events  # noqa: F401
from launcher.base.model.events import signal_name
from launcher.base.model.record import Record
from launcher.base.model.run_event import TYPES, Entry, RunEvent, UnknownEvent
from launcher.base.model.run_events import Sample

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_LATEST_S = 1e11  # in the year 5138; a larger number is no time
_GREATEST = 2.0**63  # NaN and infinity, which JSON in Python may have, are not below it
_WORDS = {"asked": "requested"}  # the name in the document, the word in the line


def entry_of(item: object) -> Entry | None:
    """The entry that this JSON value is; None if it is none.

    Fields that the type does not have, of a newer version, are left out.
    """
    if not isinstance(item, Mapping):
        return None
    try:
        wall_s, monotonic_s = _time(item["wall_s"]), _number(item["monotonic_s"])
        kind = FIELD_TYPES["str"].read(item["event"])
    except (KeyError, ValueError):
        return None
    subject = {key: item[key] for key in ("process", "host") if isinstance(item.get(key), str)}
    event = _event_of(kind, item, has_process="process" in subject)
    if event is None:
        known = {"wall_s", "monotonic_s", "event", *subject}
        event = UnknownEvent(kind, {key: item[key] for key in item if key not in known})
    elif "host" in event._fields:
        subject.pop("host", None)
    return Entry(wall_s, monotonic_s, event, **subject)


def entry_in(line: str | bytes) -> Entry | None:
    """The entry that a line of `events.jsonl` holds; None if it is none, such as one cut short."""
    from launcher.base import strict_json

    try:
        text = line.decode() if isinstance(line, bytes) else line
        return entry_of(strict_json.unpacked(text))
    except ValueError:
        return None


def line_of(entry: Entry) -> str:
    """`12:00:00 ended a-1 pid=7 returncode=SIGSEGV`: only what is known."""
    clock = time.strftime("%H:%M:%S", time.localtime(entry.wall_s))
    kind, details = entry.event.event, _details(entry.event)
    words = [clock, _WORDS.get(kind, kind)]
    words += [entry.process] if entry.process is not None else []
    words += [f"host={entry.host}"] if entry.host is not None else []
    return " ".join([*words, *details])


def annotations_of(cls: type[Record]) -> dict[str, str]:
    """The types of its fields, by their names in the source: `Seconds | None`."""
    return {name: str(cls.__annotations__[name]) for name in cls._fields}


# ---- values of fields


class EventFieldType(Record):
    """How a value of a field is read from JSON (ValueError) and shown in a line.

    `json` and `unit` are for the documents.
    """

    json: str
    unit: str
    read: Callable[[Any], Any]
    show: Callable[[Any], str] = str


def _number(value: Any) -> Any:
    if type(value) not in (int, float) or not abs(value) < _GREATEST:
        raise ValueError(value)
    return value


def _integer(value: object) -> Any:
    if type(value) is not int or not abs(value) < _GREATEST:
        raise ValueError(value)
    return value


def is_time(value: Any) -> bool:
    """Whether a value of JSON may be a time in seconds since 1970."""
    return type(value) in (int, float) and 0 <= value < _LATEST_S


def _time(value: object) -> Any:
    if not is_time(value):
        raise ValueError(value)
    return value


def _exactly(cls: type) -> Callable[[Any], Any]:
    def read(value: object) -> Any:
        if type(value) is not cls:
            raise ValueError(value)
        return value

    return read


def _names(value: object) -> tuple[str, ...]:
    if not isinstance(value, (list, tuple)) or not all(isinstance(one, str) for one in value):
        raise ValueError(value)
    return tuple(value)


def _samples(value: object) -> dict[str, Sample]:
    if not isinstance(value, Mapping):
        raise ValueError(value)
    return {str(name): Sample(**_read(Sample, sample)) for name, sample in value.items()}


def _exit(code: int) -> str:
    return signal_name(-code) if code < 0 else str(code)


def _used(samples: Mapping[str, Sample]) -> str:
    """`a-1=3%,31MB b-2=5%`: CPU and USS."""
    return " ".join(f"{name}={_usage(sample)}" for name, sample in samples.items())


def _usage(sample: Sample) -> str:
    cpu = "-" if sample.cpu_percent is None else f"{sample.cpu_percent:.0f}%"
    return cpu if sample.uss_bytes is None else f"{cpu},{sample.uss_bytes / 1e6:.0f}MB"


SAMPLES = "Mapping[str, Sample]"
# By the names of the types in `run_events`.
FIELD_TYPES = {
    "str": EventFieldType("string", "", _exactly(str)),
    "bool": EventFieldType("boolean", "", _exactly(bool)),
    "Count": EventFieldType("integer", "", _integer),
    "Names": EventFieldType("list of strings", "", _names, ",".join),
    "Percent": EventFieldType("number", "%", _number),
    "Pid": EventFieldType("integer", "", _integer),
    "ReturnCode": EventFieldType("integer", "", _integer, _exit),
    "Seconds": EventFieldType("number", "s", _number),
    "SignalNumber": EventFieldType("integer", "", _integer, signal_name),
    "Size": EventFieldType("integer", "bytes", _integer),
    SAMPLES: EventFieldType("object of objects", "", _samples, _used),
}


def _event_of(kind: str, item: Mapping[str, Any], *, has_process: bool) -> RunEvent | None:
    """The event of an entry; None if it is not as its type says."""
    cls = TYPES.get(kind)
    if cls is None or (cls.about == "process" and not has_process):
        return None
    try:
        return cls(**_read(cls, item))
    except (ValueError, TypeError):
        return None


def _read(cls: object, item: object) -> dict[str, Any]:
    """The fields of a type, from JSON; ValueError."""
    if not isinstance(item, Mapping):
        raise ValueError(item)
    # A field that is missing is a TypeError, unless it has a default.
    return {
        name: None if is_optional and item[name] is None else read(item[name])
        for name, read, is_optional in _readers(cls)
        if name in item
    }


@functools.cache
def _readers(cls: type[Record]) -> list[tuple[str, Callable[[Any], Any], bool]]:
    """Each field, what reads it, and whether it may be null."""
    types = [(name, kind.partition(" | ")) for name, kind in annotations_of(cls).items()]
    return [(name, FIELD_TYPES[kind].read, bool(rest)) for name, (kind, _, rest) in types]


def _details(event: RunEvent) -> list[str]:
    """`pid=7`, `signal=SIGINT`, `returncode=SIGSEGV`; a flag that is set is its name."""
    if isinstance(event, UnknownEvent):
        return [f"{key}={_raw(value)}" for key, value in event.fields.items()]
    found = []
    for name, annotation in annotations_of(type(event)).items():
        kind, value = annotation.partition(" | ")[0], getattr(event, name)
        if kind == SAMPLES:
            found.append(f"(CPU, USS): {_used(value)}")
        elif value is True:
            found.append(_WORDS.get(name, name))
        elif value is not None and value is not False and value not in ("", ()):
            found.append(f"{name}={FIELD_TYPES[kind].show(value)}")
    return found


def _raw(value: object) -> str:
    from launcher.base import strict_json

    return value if isinstance(value, str) else strict_json.dumps(value, default=str)
