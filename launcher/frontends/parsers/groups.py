"""`group`, `reset`, `timer` and `ros_timer`."""

from __future__ import annotations

from launcher.frontends.entity import Entity
from launcher.frontends.parsers.base import (
    Parsed,
    as_dictionary,
    children_as_actions,
    name_value_pairs,
    parse_action,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def parse_group(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`group`: nested `keep`s are configurations, all other nested entities are actions."""
    _, arguments = parse_action(cls, entity, parser)
    for name in ("scoped", "forwarding"):
        value = entity.get_attr(name, data_type=bool, optional=True)
        if value is not None:
            arguments[name] = value
    _add_kept(arguments, entity, parser)
    arguments["actions"] = children_as_actions(entity, parser, but="keep")
    return cls, arguments


def parse_reset(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`reset`."""
    _, arguments = parse_action(cls, entity, parser)
    _add_kept(arguments, entity, parser)
    return cls, arguments


def _add_kept(arguments: dict[str, Any], entity: Entity, parser: Any) -> None:
    kept = name_value_pairs(entity, parser, "keep")
    if kept is not None:
        arguments["launch_configurations"] = as_dictionary(kept)


def parse_timer(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`timer` and `ros_timer`: the period is in seconds, or substitutions that become that."""
    _, arguments = parse_action(cls, entity, parser)
    period = entity.get_attr("period", data_type=float, can_be_str=True)
    arguments["period"] = parser.parse_if_substitutions(period)
    arguments["actions"] = children_as_actions(entity, parser)
    cancel = entity.get_attr("cancel_on_shutdown", data_type=bool, optional=True, can_be_str=True)
    if cancel is not None:
        arguments["cancel_on_shutdown"] = parser.parse_if_substitutions(cancel)
    return cls, arguments
