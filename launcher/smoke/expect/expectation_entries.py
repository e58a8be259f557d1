"""The top-level and scenario entries of an expectation file, and its JSON Schema."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from launcher.base.document.fields import (
    ANYTHING,
    INTEGER,
    Field,
    FieldError,
    FieldType,
    mapping_schema,
    properties_of,
    text,
)
from launcher.base.document.quantities import DURATION
from launcher.smoke.expect.expectation_fields import REGEX
from launcher.smoke.expect.expectation_kinds import KINDS, ExpectationKind
from launcher.smoke.expect.steps import COMMAND, chaos_type


def _arguments(value: object) -> dict[str, str]:
    if not isinstance(value, Mapping):
        raise FieldError("expected a mapping of launch arguments, as in {enable_debug: true}")
    for name, one in value.items():
        if not isinstance(one, str | int | float):
            raise FieldError(f"invalid value of an argument: {one!r}", (name,))
    return {
        str(name): str(one).lower() if isinstance(one, bool) else str(one)
        for name, one in value.items()
    }


def _options(value: object) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
        raise FieldError("expected a list of strings, as in ['--restart=robot_*=always']")
    return tuple(value)


_VALUES = {"type": "object", "additionalProperties": {"type": ["string", "number", "boolean"]}}
_STRINGS = {"type": "array", "items": {"type": "string"}}

TOP_FIELDS = (
    Field("for", DURATION, "how long the system is observed once it is ready"),
    Field("ready_within", DURATION, "how long it may take to be ready"),
    Field("arguments", FieldType(_arguments, _VALUES), "launch arguments"),
    Field("options", FieldType(_options, _STRINGS), "options of the launcher"),
    Field("chaos", chaos_type(), "command repeated on randomly chosen processes"),
    Field("seed", INTEGER, "seed of the random choices of `chaos`"),
    Field("scenario", ANYTHING, "commands to the system, and when they are run"),
    Field("expect", ANYTHING, "the expectations"),
)
STEP_FIELDS = (
    Field("do", COMMAND, "command: `kill robot_2`", required=True),
    Field("at", DURATION, "time of the command after the start, or after `after`"),
    Field("after", text("step name"), "step from which `at` counts"),
    Field("after_log", REGEX, "wait for a line that matches; `at` counts from it"),
    Field("process", text("process name"), "process that prints that line"),
    Field("name", text("name"), "name of this step for `after`"),
)


def json_schema() -> dict[str, Any]:
    items = {
        "scenario": {"$ref": "#/$defs/step"},
        "expect": {"oneOf": [{"$ref": f"#/$defs/{kind.name}"} for kind in KINDS]},
    }
    properties = properties_of(TOP_FIELDS)
    for name, schema in items.items():
        properties[name] = {**properties[name], "type": ["array", "null"], "items": schema}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Expectations of a smoke run",
        "type": ["object", "null"],
        "additionalProperties": False,
        "properties": properties,
        "$defs": {
            "step": mapping_schema(STEP_FIELDS),
            **{kind.name: _kind_schema(kind) for kind in KINDS},
        },
    }


def _kind_schema(kind: ExpectationKind) -> dict[str, Any]:
    subject = Field(kind.name, kind.subject, kind.doc, required=True)
    schema = {"description": kind.doc, **mapping_schema((subject, *kind.all_fields()))}
    if kind.one_of:
        schema["anyOf"] = [{"required": [name]} for name in kind.one_of]
    return schema
