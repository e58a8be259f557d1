"""Grammar: the entries of a file of expectations beside the expectations, and its JSON Schema."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from launcher.smoke.expect.expectation_kinds import KINDS, Kind
from launcher.smoke.expect.fields import Anything, Field, FieldError, Regex, Text
from launcher.smoke.expect.quantities import DURATION
from launcher.smoke.expect.steps import ChaosType, CommandType


class Arguments:
    """Launch arguments."""

    def parse(self, value: object) -> dict[str, str]:
        """ValueError for what is no mapping of names to plain values."""
        if not isinstance(value, Mapping):
            raise FieldError("arguments are a mapping, as in {enable_debug: true}")
        for name, one in value.items():
            if not isinstance(one, str | int | float):
                raise FieldError(f"{one!r} is no value of an argument", (name,))
        return {str(name): _word(one) for name, one in value.items()}

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        return {
            "type": "object",
            "additionalProperties": {"type": ["string", "number", "boolean"]},
        }


def _word(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


class Words:
    """Texts in a list."""

    def parse(self, value: object) -> tuple[str, ...]:
        """ValueError for anything else."""
        if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
            raise FieldError("options are a list of texts, as in ['--restart=robot_*=always']")
        return tuple(value)

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        return {"type": "array", "items": {"type": "string"}}


class Seed:
    """A whole number."""

    def parse(self, value: object) -> int:
        """ValueError for anything else."""
        if isinstance(value, bool) or not isinstance(value, int):
            raise FieldError(f"{value!r} is no whole number")
        return value

    @property
    def schema(self) -> dict[str, object]:
        """As JSON Schema."""
        return {"type": "integer"}


TOP_FIELDS = (
    Field(name="for", type=DURATION, doc="how long the system is watched once it is ready"),
    Field(name="ready_within", type=DURATION, doc="how long it may take to be ready"),
    Field(name="arguments", type=Arguments(), doc="launch arguments"),
    Field(name="options", type=Words(), doc="options of the launcher"),
    Field(name="chaos", type=ChaosType(), doc="what is done again and again, to one of several"),
    Field(name="seed", type=Seed(), doc="decides what chaos chooses"),
    Field(name="scenario", type=Anything(), doc="what is done to the system, and when"),
    Field(name="expect", type=Anything(), doc="what has to be seen"),
)
STEP_FIELDS = (
    Field(name="do", type=CommandType(), doc="what is done: `kill robot_2`", required=True),
    Field(name="at", type=DURATION, doc="when: time after the start, or after `after`"),
    Field(name="after", type=Text("name of a step"), doc="step from which `at` counts"),
    Field(name="after_log", type=Regex(), doc="wait for a line that matches; `at` counts from it"),
    Field(name="process", type=Text("process"), doc="process that prints that line"),
    Field(name="name", type=Text("name"), doc="what `after` calls this step"),
)


def json_schema() -> dict[str, Any]:
    """The JSON Schema of a file of expectations, for editors."""
    properties = _properties(TOP_FIELDS)
    properties["scenario"] = {
        "description": TOP_FIELDS[-2].doc,
        "type": ["array", "null"],
        "items": {"$ref": "#/$defs/step"},
    }
    properties["expect"] = {
        "description": TOP_FIELDS[-1].doc,
        "type": ["array", "null"],
        "items": {"oneOf": [{"$ref": f"#/$defs/{kind.name}"} for kind in KINDS]},
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Expectations of a smoke run",
        "type": ["object", "null"],
        "additionalProperties": False,
        "properties": properties,
        "$defs": {
            "step": {
                "type": "object",
                "additionalProperties": False,
                "required": ["do"],
                "properties": _properties(STEP_FIELDS),
            },
            **{kind.name: _kind_schema(kind) for kind in KINDS},
        },
    }


def _properties(fields: Sequence[Field]) -> dict[str, Any]:
    return {field.name: {**field.type.schema, "description": field.doc} for field in fields}


def _kind_schema(kind: Kind) -> dict[str, Any]:
    required = [kind.name, *(field.name for field in kind.fields if field.required)]
    schema: dict[str, Any] = {
        "description": kind.doc,
        "type": "object",
        "additionalProperties": False,
        "required": required,
        "properties": {
            kind.name: {**kind.subject.schema, "description": kind.doc},
            **_properties(kind.all_fields()),
        },
    }
    if kind.one_of:
        schema["anyOf"] = [{"required": [name]} for name in kind.one_of]
    return schema
