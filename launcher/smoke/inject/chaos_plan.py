"""A seeded plan of injections, from a YAML file: the same seed gives the same plan."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping
from typing import Any

from launcher.base.document.document_reader import DocumentReader, text_of, together
from launcher.base.document.fields import (
    INTEGER,
    Field,
    FieldError,
    FieldType,
    mapping_schema,
    nested,
    parsed_entries,
    raise_all,
    shown,
)
from launcher.base.document.quantities import DURATION, WINDOW, NumberRange
from launcher.base.errors import LaunchFileError
from launcher.base.model.record import Record
from launcher.smoke.inject.grammar import Injection, lasting, parsed_line, patterns

READY = "ready"
MOST_WEIGHT = 1e6
SHORTEST_S = 0.01  # between two injections


class ChaosEntry(Record):
    """One kind of step: `name` is a pattern of processes; `for_s` replaces the injection's time."""

    name: str
    injection: Injection
    for_s: NumberRange | None = None
    weight: float = 1.0


class PlannedInjection(Record):
    """The `number`-th injection, `at_s` after the start of the plan.

    `choice`, from 0 to 1, chooses one of the processes that the entry names.
    """

    number: int
    at_s: float
    name: str
    injection: Injection
    choice: float

    @property
    def text(self) -> str:
        for_s = self.injection.for_s
        return f"{self.name} {self.injection.text}" + (f" for {for_s:.4g} s" if for_s else "")

    def target(self, names: list[str]) -> str | None:
        """One of the names of processes that match; None if none does."""
        return names[int(self.choice * len(names))] if names else None


class ChaosPlan(Record):
    """`start_s` is None if it begins when the system is ready; `for_s`: how long it goes on."""

    entries: tuple[ChaosEntry, ...]
    every: NumberRange
    seed: int
    start_s: float | None = None
    for_s: float | None = None

    def steps(self) -> Iterator[PlannedInjection]:
        """All of them, without end unless `for_s` is given.

        Each takes four random numbers, whatever became of those before.
        """
        numbers, at_s, number = random.Random(self.seed), 0.0, 0
        weights = [one.weight for one in self.entries]
        while True:
            pause, which, time, choice = (numbers.random() for _ in range(4))
            at_s += max(SHORTEST_S, _between(self.every, pause))
            if self.for_s is not None and at_s > self.for_s:
                return
            number += 1
            entry = _weighted(self.entries, weights, which)
            injection = entry.injection
            if entry.for_s is not None:
                injection = lasting(injection, _between(entry.for_s, time))
            yield PlannedInjection(number, at_s, entry.name, injection, choice)


def _between(window: NumberRange, part: float) -> float:
    """A single time is a window from 0, and means just that."""
    has_low = ".." in window.text or "to" in window.text
    return window.low + part * (window.high - window.low) if has_low else window.high


def _weighted(entries: tuple[ChaosEntry, ...], weights: list[float], which: float) -> ChaosEntry:
    left = which * sum(weights)
    for entry, weight in zip(entries, weights, strict=True):
        left -= weight
        if left < 0:
            return entry
    return entries[-1]


# ---- the file


def _weight(value: object) -> float:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not 0 < value <= MOST_WEIGHT:  # type: ignore[operator]
        raise FieldError(f"{shown(value)} is not a number above 0")
    return float(value)  # type: ignore[arg-type]


def _positive(value: object) -> NumberRange:
    window: NumberRange = WINDOW.parse(value)
    if window.high <= 0.0:
        raise FieldError("it must be longer than 0 s")
    return window


def _start(value: object) -> float | None:
    return None if value == READY else float(DURATION.parse(value))


_INJECT = FieldType(
    parsed_line,
    {
        "anyOf": [
            {"type": "string", "pattern": f"^ *{pattern} *$", "examples": [example]}
            for pattern, example in patterns()
        ]
    },
)
_WINDOW = FieldType(_positive, WINDOW.schema)
ENTRY_FIELDS = (
    Field("inject", _INJECT, "a process or a pattern, and what: `robot_* slow 4`", required=True),
    Field("for", _WINDOW, "how long: `3 s`, or by chance `1 to 5 s`"),
    Field(
        "weight",
        FieldType(_weight, {"type": "number", "exclusiveMinimum": 0}),
        "how often, in proportion to the others",
    ),
)


def _entry(value: object) -> ChaosEntry:
    if not isinstance(value, Mapping):
        raise FieldError(f"{shown(value)} is no injection", hint="as in {inject: robot_* slow 4}")
    known = {field.name: field.type for field in ENTRY_FIELDS}
    found, errors = parsed_entries(value, known, "an injection")
    if "inject" not in value:
        errors.append(FieldError("an injection needs 'inject'"))
    raise_all(errors)
    name, injection = found["inject"]
    if "for" in found and injection.for_s is None:
        raise FieldError(f"{injection.kind} takes no time: it happens at once", ("for",))
    return ChaosEntry(name, injection, found.get("for"), found.get("weight", 1.0))


def _entries(value: object) -> tuple[ChaosEntry, ...]:
    if not isinstance(value, list) or not value:
        raise FieldError("expected a list of injections", hint="as in [{inject: robot_* slow 4}]")
    found: list[ChaosEntry] = []
    errors: list[FieldError] = []
    for place, one in enumerate(value):
        try:
            found.append(nested(_entry, one, place))
        except FieldError as error:
            errors += error.all
    raise_all(errors)
    return tuple(found)


FIELDS = (
    Field(
        "injections",
        FieldType(
            _entries, {"type": "array", "minItems": 1, "items": mapping_schema(ENTRY_FIELDS)}
        ),
        "what may be injected",
        required=True,
    ),
    Field("every", _WINDOW, "from one to the next: `10 s`, or `5 to 20 s`", required=True),
    Field("seed", INTEGER, "the same seed gives the same plan; default: another one each time"),
    Field(
        "start",
        FieldType(_start, {"anyOf": [{"const": READY}, DURATION.schema]}),
        "`ready` (default), or a time after the start of the run",
    ),
    Field("for", DURATION, "how long the plan goes on; default: until the end of the run"),
)


def json_schema() -> dict[str, Any]:
    """The JSON Schema of such files, for editors."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Plan of injected faults",
        **mapping_schema(FIELDS),
    }


def parse(text: str, path: str) -> ChaosPlan:
    """LauncherError with all mistakes, and their lines."""
    reader = DocumentReader(text, path, what="a plan of injections", hint="as in 'every: 10 s'")
    document = reader.document()
    if document is None and not reader.errors:
        hint = "it needs 'injections' and 'every'"
        raise LaunchFileError("the plan is empty", hint=hint, where=path)
    values = {} if document is None else reader.fields(document, FIELDS, (), "the plan")
    if reader.errors:
        raise together(reader.errors)
    return ChaosPlan(
        values["injections"],
        values["every"],
        values.get("seed", random.randrange(1_000_000)),
        values.get("start"),
        values.get("for"),
    )


def load(path: str) -> ChaosPlan:
    """The plan of a file; LauncherError with all mistakes."""
    return parse(text_of(path, "the plan of injections"), path)
