"""`arg`, `let` and `unset`."""

from __future__ import annotations

from launcher.frontends.entity import Entity
from launcher.frontends.parsers.base import ENTITIES, Parsed, parse_action, parse_texts

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def parse_argument(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`arg`: name, description and choices are texts, the default may hold substitutions."""
    _, arguments = parse_action(cls, entity, parser)
    arguments["name"] = parser.escape_characters(entity.get_attr("name"))
    default = entity.get_attr("default", optional=True)
    if default is not None:
        arguments["default_value"] = parser.parse_substitution(default)
    description = entity.get_attr("description", optional=True)
    if description is not None:
        arguments["description"] = parser.escape_characters(description)
    choices = entity.get_attr("choice", data_type=ENTITIES, optional=True)
    if choices is not None:
        arguments["choices"] = [
            parser.escape_characters(choice.get_attr("value")) for choice in choices
        ]
    return cls, arguments


def parse_let(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`let`."""
    return parse_texts(cls, entity, parser, {"name": "name", "value": "value"})


def parse_unset(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`unset`."""
    return parse_texts(cls, entity, parser, {"name": "name"})
