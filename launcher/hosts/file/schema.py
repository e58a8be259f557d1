"""The JSON Schema of hosts files, for editors: `launcher/hosts/hosts.schema.json`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from launcher.base.document.fields import properties_of
from launcher.hosts.file.discovery_field import DISCOVERY
from launcher.hosts.file.host_fields import HOST_FIELDS, HOST_NAME, NOT_DEFAULT


def json_schema() -> dict[str, Any]:
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Hosts of a run",
        "type": "object",
        "additionalProperties": False,
        "required": ["hosts"],
        "properties": {
            "hosts": {
                "description": "the hosts by name; a text is an address",
                "type": "object",
                "minProperties": 1,
                "propertyNames": {"pattern": f"^{HOST_NAME}$", "not": {"const": "local"}},
                "additionalProperties": {
                    "anyOf": [{"type": "string", "minLength": 1}, {"$ref": "#/$defs/host"}]
                },
            },
            "defaults": {
                "description": "for all hosts",
                **_entries(NOT_DEFAULT),
                "type": ["object", "null"],
            },
            "place": {
                "description": "pattern of processes to the name of a host, or to `local`",
                "type": ["object", "null"],
                "additionalProperties": {"type": "string", "minLength": 1},
            },
            "discovery": {**DISCOVERY.schema, "description": "how the nodes find each other"},
        },
        "$defs": {
            "host": {**_entries(()), "required": ["address"]},
            **properties_of(HOST_FIELDS),
        },
    }


def _entries(without: Iterable[str]) -> dict[str, Any]:
    fields = [field for field in HOST_FIELDS if field.name not in without]
    return {
        "type": "object",
        "additionalProperties": False,
        "properties": {field.name: {"$ref": f"#/$defs/{field.name}"} for field in fields},
        "not": {"type": "object", "required": ["python", "venv"]},
    }
