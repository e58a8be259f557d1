"""Examples of every event of a run, made from the types of their fields."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from launcher.base.model.event_entries import SAMPLES, annotations_of
from launcher.base.model.record import Record, as_dict
from launcher.base.model.run_event import TYPES, Entry, RunEvent, UnknownEvent
from launcher.base.model.run_events import Sample

T0 = 1_795_000_000.0
HOSTILE = "two\nlines \x1b[31mred\x1b[0m \udcff é漢 {x} %s <b>"

# The first value of each is a plausible one, the others are at the edges of what there may be.
VALUES: dict[str, tuple[Any, ...]] = {
    "str": ("because", "", HOSTILE),
    "bool": (False, True),
    "Count": (2, 0, 2**31),
    "Names": (("a-1", "b-2"), (), (HOSTILE,)),
    "Percent": (12.5, 0, 6400.0),
    "Pid": (4242, 2**22),
    "ReturnCode": (3, 0, -9, -15, -64, 255),  # 64 is SIGRTMAX
    "Seconds": (1.25, 0, 0.0, 1e-9, 31_536_000.123456),
    "SignalNumber": (10, 2, 9, 40, 64),  # 40 has no name
    "Size": (31_000_000, 0, 2**40),
}


def values_of(annotation: str) -> tuple[Any, ...]:
    """Values of a field of this type: `Seconds | None`."""
    kind, _, optional = annotation.partition(" | ")
    if kind == SAMPLES:
        return ({f"a-{n}": sample for n, sample in enumerate(variants(Sample))}, {})
    return (*VALUES[kind], None) if optional else VALUES[kind]


def variants(cls: type[Record]) -> Iterator[Any]:
    """A record for every value that one of its fields may have, beside plausible ones."""
    types = annotations_of(cls)
    usual = {name: values_of(annotation)[0] for name, annotation in types.items()}
    yield cls(**usual)
    for name, annotation in types.items():
        for value in values_of(annotation)[1:]:
            yield cls(**{**usual, name: value})


def event(kind: str | type[RunEvent], **given: Any) -> RunEvent:
    """An event with these fields; the others are plausible, or have their default."""
    cls = TYPES[kind] if isinstance(kind, str) else kind
    needed = {n: values_of(a)[0] for n, a in annotations_of(cls).items() if n in cls._required}
    return cls(**{**needed, **given})


def entry(
    of: RunEvent, at_s: float = 0.0, process: str | None = "a-1", host: str | None = None
) -> Entry:
    """Its entry, `at_s` seconds after `T0`; only an event about a process has one."""
    is_of_process = of.about != "run" or isinstance(of, UnknownEvent)
    subject = (process, host) if is_of_process else (None, None)
    return Entry(T0 + at_s, at_s, of, *subject)


def entries_of(cls: type[RunEvent]) -> list[Entry]:
    """All variants of an event, here and on another host, a tenth of a second apart."""
    found = [(one, host) for one in variants(cls) for host in (None, "bot1")]
    return [entry(one, n / 10, host=host) for n, (one, host) in enumerate(found)]


def line(one: Entry) -> str:
    """Its line in `events.jsonl`, without the newline."""
    return json.dumps(one.item, default=as_dict)


def odd_items() -> list[Any]:
    """JSON values that are no entries of this version, though some of them nearly are."""
    whole = [json.loads(line(entry(event(cls)))) for cls in TYPES.values()]
    subject = {"wall_s", "monotonic_s", "event"}
    lacking = [{k: v for k, v in one.items() if k != key} for one in whole for key in one]
    wrong = [{**one, key: [{}]} for one in whole for key in one]
    null = [{**one, key: None} for one in whole for key in one.keys() - subject]
    times = {"wall_s": T0, "monotonic_s": 1.0}
    sample = as_dict(next(variants(Sample)))
    return [
        *(one for one in (*lacking, *wrong, *null)),
        {**times, "event": "asked", "process": "a-1", "verb": "kill", "signal": "SIGUSR1"},
        {**times, "event": "teleported", "process": "a-1", "speed": 3, "by": [HOSTILE]},
        {**times, "event": "teleported"},
        {**times, "event": "ended", "process": "a-1", "pid": 7, "returncode": 10**30,
         "asked": "yes", "restart_in_s": float("nan")},
        {**times, "event": "ready", "process": "a-1", "ready_s": 10**400},
        {**times, "event": "resources", "processes": {"a-1": {**sample, "uss_bytes": 10**400}}},
        {"wall_s": float("nan"), "monotonic_s": 1.0, "event": "started"},
        {"wall_s": 1e300, "monotonic_s": 1.0, "event": "started"},
        {"wall_s": -1.0, "monotonic_s": True, "event": "started"},
        {}, [], None, 7, "started", True,
    ]  # fmt: off


def odd_lines() -> list[str]:
    """Lines that a reader may find in `events.jsonl`."""
    cut = line(entry(event("ended")))
    cuts = [cut[:length] for length in range(0, len(cut), 7)]
    return [*map(json.dumps, odd_items()), *cuts, "[" * 100_000, "\0\0\0", "{} {}"]
