"""The JSON Schema of supervision files, for editors: `supervise.schema.json` in this folder."""

from __future__ import annotations

from typing import Any

from launcher.launch.supervise.fields import FIELDS


def json_schema() -> dict[str, Any]:
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Supervision of the processes of a launch file",
        "type": ["object", "null"],
        "propertyNames": {"minLength": 1},
        "additionalProperties": {"$ref": "#/$defs/process"},
        "$defs": {
            "process": {
                "description": "the processes that the name or pattern matches",
                "type": "object",
                "additionalProperties": False,
                "properties": {
                    field.name: {**field.type.schema, "description": field.doc} for field in FIELDS
                },
            }
        },
    }
