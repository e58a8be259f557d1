"""The tools as an OpenAPI document, for `/openapi.json` of the page's server."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from launcher import __version__
from launcher.web.remote.tool import Tool

_TEXTS = {"type": "array", "items": {"type": "string"}}
_OPTIONAL_TEXT = {"type": ["string", "null"]}
_SCHEMAS = {
    "Answer": {
        "type": "object",
        "required": ["result", "text"],
        "properties": {
            "result": {"type": "object", "description": "for programs"},
            "text": {**_TEXTS, "description": "for people, in lines"},
        },
    },
    "Problem": {
        "type": "object",
        "required": ["error"],
        "properties": {
            "error": {
                "type": "object",
                "required": ["code", "message", "hint"],
                "properties": {
                    "code": {"type": "string"},
                    "message": {"type": "string"},
                    "hint": _OPTIONAL_TEXT,
                },
            }
        },
    },
}


def document(tools: Iterable[Tool]) -> dict[str, Any]:
    """OpenAPI 3.1: a POST for each tool, and a GET without what changes something."""
    return {
        "openapi": "3.1.0",
        "info": {
            "title": "A run of the ROS 2 launcher",
            "version": __version__,
            "description": "The verbs about a run, with their options.",
        },
        "security": [{"token": []}],
        "paths": {f"/api/{tool.name}": _operations(tool) for tool in tools},
        "components": {
            "securitySchemes": {"token": {"type": "http", "scheme": "bearer"}},
            "schemas": _SCHEMAS,
        },
    }


def _operations(tool: Tool) -> dict[str, Any]:
    body = {
        "required": any(one.is_required for one in tool.arguments),
        "content": {"application/json": {"schema": tool.schema()}},
    }
    found = {"post": {"operationId": tool.name, "requestBody": body, **_common(tool)}}
    if (reading := tool.only_reading) is not None:
        schema = reading.schema()
        parameters = list(map(_parameter, schema["properties"].items()))
        required = schema.get("required", ())
        for parameter in parameters:
            parameter["required"] = parameter["name"] in required
        found["get"] = {
            "operationId": f"get_{tool.name}",
            "parameters": parameters,
            **_common(tool),
        }
    return found


def _common(tool: Tool) -> dict[str, Any]:
    return {
        "summary": tool.help,
        "description": tool.description,
        "responses": {
            "200": _response("what the verb answers", "Answer"),
            "default": _response("why it was not done", "Problem"),
        },
    }


def _parameter(item: tuple[str, dict[str, Any]]) -> dict[str, Any]:
    name, schema = item
    return {"name": name, "in": "query", "schema": schema}


def _response(description: str, schema: str) -> dict[str, Any]:
    reference = {"$ref": f"#/components/schemas/{schema}"}
    return {"description": description, "content": {"application/json": {"schema": reference}}}
