"""`include`."""

from __future__ import annotations

from launcher.frontends.entity import Entity
from launcher.frontends.parsers.base import Parsed, name_value_pairs, parse_action

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def parse_include(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`include` with its `arg`s."""
    _, arguments = parse_action(cls, entity, parser)
    arguments["launch_description_source"] = parser.parse_substitution(entity.get_attr("file"))
    given = name_value_pairs(entity, parser, "arg")
    if given is not None:
        arguments["launch_arguments"] = given
    return cls, arguments
