"""Fields: the types of the entries of an expectation or a step; each parses and has a schema."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from launcher.smoke.expect.conditions import Conditions, Expression, compile_regex


class FieldError(ValueError):
    """What is wrong with a value; `path` are the keys from the value to the spot.

    `key` is whether the spot is the last key itself. `all` are several mistakes in one value.
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


def together(errors: list[FieldError]) -> FieldError:
    """One error that tells all."""
    first = errors[0]
    first.all = tuple(errors)
    return first


class FieldType(Protocol):
    """Parses a plain value of YAML (ValueError with a sentence) and describes itself."""

    def parse(self, value: object) -> Any:
        """The value as the judges want it."""

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Field:
    """An entry beside the kind's own."""

    name: str
    type: FieldType
    doc: str
    required: bool = False


def near(word: object, known: list[str]) -> str | None:
    """A hint with the most similar known word, or all of them."""
    found = difflib.get_close_matches(str(word), known, n=1)
    if found:
        return f"did you mean '{found[0]}'?"
    return f"there is {', '.join(known)}" if known else None


class Text:
    """A text that is not empty."""

    def __init__(self, noun: str = "text") -> None:
        self._noun = noun

    def parse(self, value: object) -> str:
        """ValueError for anything but a text."""
        if not isinstance(value, str) or not value:
            raise FieldError(f"{value!r} is no {self._noun}, which is a text")
        return value

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        return {"type": "string", "minLength": 1}


class Name:
    """A full name in the ROS graph."""

    pattern = r"/[^ ]*"

    def __init__(self, noun: str) -> None:
        self._noun = noun

    def parse(self, value: object) -> str:
        """ValueError for what does not begin with a slash."""
        if not isinstance(value, str) or not value.startswith("/") or " " in value:
            hint = f"full names begin with '/': /{value}" if isinstance(value, str) else None
            raise FieldError(f"{value!r} is no name of a {self._noun}", hint=hint)
        return value

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        return {"type": "string", "pattern": f"^{self.pattern}$"}


class NamePattern(Name):
    """A full name in the ROS graph, or a pattern of such names."""

    pattern = r"[/*?\[][^ ]*"

    def parse(self, value: object) -> str:
        """ValueError for what no full name can fit."""
        if isinstance(value, str) and value[:1] in ("*", "?", "[") and " " not in value:
            return value
        return super().parse(value)


class TypeName:
    """The full name of a type; `std_msgs/String` is short for `std_msgs/msg/String`."""

    pattern = r"[A-Za-z][A-Za-z0-9_]*(?:/[a-z]+)?/[A-Za-z][A-Za-z0-9_]*"

    def __init__(self, kind: str, example: str) -> None:
        self._kind = kind
        self._example = example

    def parse(self, value: object) -> str:
        """ValueError for what has no package."""
        if not isinstance(value, str) or re.fullmatch(self.pattern, value) is None:
            raise FieldError(f"{value!r} is no type, which is written as {self._example}")
        package, *_, name = value.split("/")
        return f"{package}/{self._kind}/{name}" if value.count("/") == 1 else value

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        return {"type": "string", "pattern": f"^{self.pattern}$"}


class Choice:
    """One of some words."""

    def __init__(self, *words: str) -> None:
        self._words = list(words)

    def parse(self, value: object) -> str:
        """ValueError for another word."""
        if value not in self._words:
            raise FieldError(
                f"{value!r} is none of {', '.join(self._words)}", hint=near(value, self._words)
            )
        return str(value)

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        return {"enum": self._words}


class Flag:
    """True or false."""

    def parse(self, value: object) -> bool:
        """ValueError for anything else."""
        if not isinstance(value, bool):
            raise FieldError(f"{value!r} is neither true nor false")
        return value

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        return {"type": "boolean"}


class Regex:
    """A regular expression of Python, searched for in the text without colours."""

    def parse(self, value: object) -> Any:
        """ValueError for a mistake in it."""
        return compile_regex(value)

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        return {"type": "string"}


class Regexes:
    """Some regular expressions."""

    def __init__(self, least: int = 1) -> None:
        self._least = least

    def parse(self, value: object) -> Any:
        """ValueError for a mistake in one of them."""
        if not isinstance(value, list) or len(value) < self._least:
            raise FieldError(f"{value!r} is no list of at least {self._least} regular expressions")
        return tuple(_nested(compile_regex, one, number) for number, one in enumerate(value))

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        return {"type": "array", "items": {"type": "string"}, "minItems": self._least}


def _nested(parse: Any, value: object, *path: object) -> Any:
    try:
        return parse(value)
    except ValueError as error:
        raise FieldError(str(error), path, getattr(error, "hint", None)) from None


class Where:
    """A Python expression over a message."""

    def parse(self, value: object) -> Expression:
        """ValueError for a mistake in it."""
        return Expression.parse(value)

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        return {"type": "string", "minLength": 1}


class FieldConditions:
    """Field paths and what they have to be."""

    def parse(self, value: object) -> Conditions:
        """ValueError for a mistake in it."""
        return Conditions.parse(value)

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        limits = {
            "type": "object",
            "properties": {
                "min": {"type": "number"},
                "max": {"type": "number"},
                "matches": {"type": "string"},
                "not": {},
            },
            "additionalProperties": False,
        }
        value = {"anyOf": [{"not": {"type": "object"}}, limits]}
        return {"type": "object", "minProperties": 1, "additionalProperties": value}


class Anything:
    """Any value."""

    def parse(self, value: object) -> object:
        """The value itself."""
        return value

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        return {}


class Mapped:
    """A mapping of any content, as messages and requests are."""

    def parse(self, value: object) -> object:
        """ValueError for anything else."""
        if not isinstance(value, Mapping):
            raise FieldError(f"{value!r} is no mapping of fields to values, as in {{data: hello}}")
        return value

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        return {"type": "object"}


class RecordField:
    """A mapping with known entries."""

    def __init__(self, noun: str, **entries: FieldType) -> None:
        self._noun = noun
        self._entries = entries

    def parse(self, value: object) -> dict[str, Any]:
        """ValueError at the entry that is wrong."""
        if not isinstance(value, Mapping) or not value:
            raise FieldError(f"{self._noun} is a mapping with {', '.join(self._entries)}")
        found: dict[str, Any] = {}
        errors: list[FieldError] = []
        for name, one in value.items():
            if name not in self._entries:
                hint = near(name, list(self._entries))
                errors.append(FieldError(f"{self._noun} has no '{name}'", (name,), hint, key=True))
                continue
            try:
                found[str(name)] = _nested(self._entries[name].parse, one, name)
            except FieldError as error:
                errors.append(error)
        if errors:
            raise together(errors)
        return found

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        return {
            "type": "object",
            "properties": {name: entry.schema for name, entry in self._entries.items()},
            "additionalProperties": False,
            "minProperties": 1,
        }
