"""What releases after Jazzy added: loops, messages of other levels, `rep_env`."""

from __future__ import annotations

from launcher.frontends.entity import Entity
from launcher.frontends.parsers.base import (
    Parsed,
    as_dictionary,
    children_as_actions,
    name_value_pairs,
    parse_action,
    parse_texts,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def parse_log(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`log_debug`, `log_warning` and `log_error`; `log_info` is `log`."""
    return parse_texts(cls, entity, parser, {"msg": "message"})


def parse_environment(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`rep_env`."""
    _, arguments = parse_action(cls, entity, parser)
    env = name_value_pairs(entity, parser, "env")
    if env is not None:
        arguments["environment"] = as_dictionary(env)
    return cls, arguments


def parse_for_each(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`for_each`: the nested actions once for each set of values, seen by `$(for-var name)`."""
    _, arguments = parse_texts(cls, entity, parser, {"input_values": "values"})
    children_as_actions(entity, parser)  # mistakes are told now, not in the first turn

    def turn(**values: Any) -> list[Any]:
        return _turn(entity, parser, "for_each_values", values)

    return cls, {**arguments, "function": turn}


def parse_for(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`for`: the nested actions `len` times; `$(index name)` counts from 0."""
    _, arguments = parse_texts(cls, entity, parser, {"length": "len"})
    arguments["name"] = name = entity.get_attr("name")
    children_as_actions(entity, parser)

    def turn(index: int) -> list[Any]:
        return _turn(entity, parser, "for_loop_indices", {name: index})

    return cls, {**arguments, "function": turn}


def _turn(entity: Entity, parser: Any, local: str, values: dict[str, Any]) -> list[Any]:
    """New actions for each turn, since an action runs once, with their values around them."""
    from launcher.language.actions.events import OpaqueFunction

    def enter(context: Any) -> None:
        context._push_locals()
        known = context.get_locals_as_dict().get(local, {})
        context.extend_locals({local: {**known, **values}})

    return [
        OpaqueFunction(function=enter),
        *children_as_actions(entity, parser),
        OpaqueFunction(function=lambda context: context._pop_locals()),
    ]
