"""Types of the entries of a document: each parses a value and has a JSON Schema."""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from launcher.base.text import did_you_mean


class FieldError(ValueError):
    """An invalid value; `path` are the keys from the value to the place of the mistake.

    `key`: the last key itself is wrong, not its value. `all`: several mistakes in one value.
    """

    def __init__(
        self,
        message: str,
        path: tuple[object, ...] = (),
        hint: str | None = None,
        *,
        key: bool = False,
    ) -> None:
        super().__init__(message)
        self.path = path
        self.hint = hint
        self.key = key
        self.all: tuple[FieldError, ...] = (self,)


_REPR = reprlib.Repr()
_REPR.maxlevel, _REPR.maxstring, _REPR.maxother = 3, 200, 200


def shown(value: object) -> str:
    """A value for a message, cut short: aliases may make it of any size."""
    return _REPR.repr(value)


def raise_all(errors: Sequence[FieldError]) -> None:
    """Raise several mistakes in one value as one; nothing if there is none."""
    if errors:
        errors[0].all = tuple(errors)
        raise errors[0]


@dataclass(frozen=True, slots=True)
class FieldType:
    """`parse` turns a value of YAML into what the judges take; ValueError if it is invalid."""

    parse: Callable[[object], Any]
    schema: Mapping[str, object]


@dataclass(frozen=True, slots=True)
class Field:
    name: str
    type: FieldType
    doc: str
    required: bool = False


def properties_of(fields: Iterable[Field]) -> dict[str, Any]:
    """The `properties` of the schema of a mapping with these entries."""
    return {field.name: {**field.type.schema, "description": field.doc} for field in fields}


def mapping_schema(fields: Sequence[Field]) -> dict[str, Any]:
    """The JSON Schema of a mapping with these entries and no others."""
    return {
        "type": "object",
        "additionalProperties": False,
        "required": [field.name for field in fields if field.required],
        "properties": properties_of(fields),
    }


def near(word: object, known: Collection[str]) -> str | None:
    """`did you mean 'node'?`, or all known words."""
    listed = f"known: {', '.join(known)}" if known else None
    return did_you_mean(str(word), known) or listed


def text(noun: str = "text") -> FieldType:
    def parse(value: object) -> str:
        if not isinstance(value, str) or not value:
            raise FieldError(f"{shown(value)} is not a {noun}: expected a non-empty string")
        return value

    return FieldType(parse, {"type": "string", "minLength": 1})


def choice(*words: str) -> FieldType:
    known = list(words)

    def parse(value: object) -> str:
        if value not in known:
            hint = did_you_mean(str(value), known)
            raise FieldError(f"{shown(value)} is not one of {', '.join(known)}", hint=hint)
        return str(value)

    return FieldType(parse, {"enum": known})


def instance(kind: type, noun: str, schema: Mapping[str, object]) -> FieldType:
    """Any value of a class, as it is; `True` is not an integer."""

    def parse(value: object) -> object:
        if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
            raise FieldError(f"{shown(value)} is not {noun}")
        return value

    return FieldType(parse, schema)


def nested(parse: Callable[[object], Any], value: object, *path: object) -> Any:
    try:
        return parse(value)
    except ValueError as error:
        raise_all([_below(path, one) for one in getattr(error, "all", (error,))])
        raise


def _below(path: tuple[object, ...], error: ValueError) -> FieldError:
    inner: tuple[object, ...] = getattr(error, "path", ())
    key = getattr(error, "key", False)
    return FieldError(str(error), (*path, *inner), getattr(error, "hint", None), key=key)


def parsed_entries(
    value: Mapping[object, object], known: Mapping[str, FieldType], noun: str
) -> tuple[dict[str, Any], list[FieldError]]:
    """The values of a mapping by their keys, and all mistakes in it."""
    found: dict[str, Any] = {}
    errors: list[FieldError] = []
    for key, one in value.items():
        if key not in known:
            hint = near(key, known)
            errors.append(FieldError(f"{noun} has no '{key}'", (key,), hint, key=True))
            continue
        try:
            found[str(key)] = nested(known[str(key)].parse, one, key)
        except FieldError as error:
            errors += error.all
    return found, errors


def record(noun: str, **entries: FieldType) -> FieldType:
    """A mapping with known keys."""

    def parse(value: object) -> dict[str, Any]:
        if not isinstance(value, Mapping) or not value:
            raise FieldError(f"{noun}: expected a mapping with {', '.join(entries)}")
        found, errors = parsed_entries(value, entries, noun)
        raise_all(errors)
        return found

    schema: dict[str, object] = {
        "type": "object",
        "properties": {key: entry.schema for key, entry in entries.items()},
        "additionalProperties": False,
        "minProperties": 1,
    }
    return FieldType(parse, schema)


ANYTHING = FieldType(lambda value: value, {})
FLAG = instance(bool, "true or false", {"type": "boolean"})
INTEGER = instance(int, "an integer", {"type": "integer"})
MAPPING = instance(Mapping, "a mapping such as {data: hello}", {"type": "object"})
