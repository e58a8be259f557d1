"""`set_env`, `append_env` and `unset_env`."""

from __future__ import annotations

from launcher.frontends.entity import Entity
from launcher.frontends.parsers.base import Parsed, add_texts, parse_texts

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_NAME_AND_VALUE = {"name": "name", "value": "value"}


def parse_set(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`set_env`."""
    return parse_texts(cls, entity, parser, _NAME_AND_VALUE)


def parse_append(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`append_env`: `prepend` is a truth value, or substitutions that become one."""
    _, arguments = parse_texts(cls, entity, parser, _NAME_AND_VALUE)
    prepend = entity.get_attr("prepend", data_type=bool, optional=True, can_be_str=True)
    if prepend is not None:
        arguments["prepend"] = parser.parse_if_substitutions(prepend)
    add_texts(arguments, entity, parser, {"separator": "separator"}, optional=True)
    return cls, arguments


def parse_unset(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`unset_env`."""
    return parse_texts(cls, entity, parser, {"name": "name"})
