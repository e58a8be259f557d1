"""Parse functions of actions, except those of processes and nodes."""

from __future__ import annotations

import warnings

from launcher.language.frontends.entity import Entity
from launcher.language.frontends.parsers.attributes import (
    ENTITIES,
    Parsed,
    add_texts,
    as_dictionary,
    children_as_actions,
    name_value_pairs,
    parse_action,
    parse_texts,
)
from launcher.language.substitution import plain_text

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.frontends.parser import Parser

_WITHOUT_LEVEL = "newer releases of ROS 2 require a 'level' for <log>, or <log_info>"


def parse_argument(cls: type, entity: Entity, parser: Parser) -> Parsed:
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


def parse_boolean_argument(cls: type, entity: Entity, parser: Parser) -> Parsed:
    """`bool_arg`: an argument whose choices are the spellings of true and false."""
    _, arguments = parse_argument(cls, entity, parser)
    if "choices" in arguments:
        raise ValueError("Cannot specify choices for bool_arg")
    return cls, arguments


def parse_append(cls: type, entity: Entity, parser: Parser) -> Parsed:
    """`append_env`: `prepend` is a truth value, or substitutions that yield one."""
    _, arguments = parse_texts(cls, entity, parser, {"name": "name", "value": "value"})
    prepend = entity.get_attr("prepend", data_type=bool, optional=True, can_be_str=True)
    if prepend is not None:
        arguments["prepend"] = parser.parse_if_substitutions(prepend)
    add_texts(arguments, entity, parser, {"separator": "separator"}, optional=True)
    return cls, arguments


def parse_environment(cls: type, entity: Entity, parser: Parser) -> Parsed:
    """`rep_env`."""
    _, arguments = parse_action(cls, entity, parser)
    env = name_value_pairs(entity, parser, "env")
    if env is not None:
        arguments["environment"] = as_dictionary(env)
    return cls, arguments


def parse_include(cls: type, entity: Entity, parser: Parser) -> Parsed:
    """`include` with its `arg`s, and its `let`s after them."""
    _, arguments = parse_action(cls, entity, parser)
    arguments["launch_description_source"] = parser.parse_substitution(entity.get_attr("file"))
    given = [pair for tag in ("arg", "let") for pair in name_value_pairs(entity, parser, tag) or ()]
    if given:
        arguments["launch_arguments"] = given
    return cls, arguments


def parse_group(cls: type, entity: Entity, parser: Parser) -> Parsed:
    """`group`: nested `keep`s are configurations, all other nested entities are actions."""
    _, arguments = parse_action(cls, entity, parser)
    for name in ("scoped", "forwarding"):
        value = entity.get_attr(name, data_type=bool, optional=True)
        if value is not None:
            arguments[name] = value
    _add_kept(arguments, entity, parser)
    arguments["actions"] = children_as_actions(entity, parser, but="keep")
    return cls, arguments


def parse_reset(cls: type, entity: Entity, parser: Parser) -> Parsed:
    """`reset`."""
    _, arguments = parse_action(cls, entity, parser)
    _add_kept(arguments, entity, parser)
    return cls, arguments


def _add_kept(arguments: dict[str, Any], entity: Entity, parser: Parser) -> None:
    kept = name_value_pairs(entity, parser, "keep")
    if kept is not None:
        arguments["launch_configurations"] = as_dictionary(kept)


def parse_timer(cls: type, entity: Entity, parser: Parser) -> Parsed:
    """`timer` and `ros_timer`: the period is in seconds, or substitutions that yield them."""
    _, arguments = parse_action(cls, entity, parser)
    period = entity.get_attr("period", data_type=float, can_be_str=True)
    arguments["period"] = parser.parse_if_substitutions(period)
    arguments["actions"] = children_as_actions(entity, parser)
    cancel = entity.get_attr("cancel_on_shutdown", data_type=bool, optional=True, can_be_str=True)
    if cancel is not None:
        arguments["cancel_on_shutdown"] = parser.parse_if_substitutions(cancel)
    return cls, arguments


def parse_for_each(cls: type, entity: Entity, parser: Parser) -> Parsed:
    """`for_each`: the nested actions once for each set of values, seen by `$(for-var name)`."""
    _, arguments = parse_texts(cls, entity, parser, {"input_values": "values"})
    children_as_actions(entity, parser)  # report errors now, not in the first iteration

    def iteration(**values: object) -> list[Any]:
        return _iteration(entity, parser, values)

    return cls, {**arguments, "function": iteration}


def parse_for(cls: type, entity: Entity, parser: Parser) -> Parsed:
    """`for`: the nested actions `len` times; `$(index name)` counts from 0."""
    _, arguments = parse_texts(cls, entity, parser, {"length": "len"})
    arguments["name"] = name = entity.get_attr("name")
    children_as_actions(entity, parser)

    def iteration(index: int) -> list[Any]:
        return _iteration(entity, parser, {name: index})

    return cls, {**arguments, "function": iteration}


def _iteration(entity: Entity, parser: Parser, values: dict[str, Any]) -> list[Any]:
    """New actions for each iteration, since an action runs once; `values` are locals for them."""
    from launcher.language.actions.event_actions import OpaqueFunction
    from launcher.language.substitutions.for_loop_var import ForEachVar

    local_values = {ForEachVar.get_local_arg_name(name): values[name] for name in values}
    return [
        OpaqueFunction(function=lambda context: context._push_locals()),
        OpaqueFunction(function=lambda context: context.extend_locals(local_values)),
        *children_as_actions(entity, parser),
        OpaqueFunction(function=lambda context: context._pop_locals()),
    ]


def parse_log(cls: type, entity: Entity, parser: Parser) -> Parsed:
    """`log`; newer releases of ROS 2 have an attribute `level`, and want it."""
    _, arguments = parse_texts(cls, entity, parser, {"msg": "message"})
    level = entity.get_attr("level", optional=True)
    if level is None:
        if entity.type_name == "log":
            warnings.warn(_WITHOUT_LEVEL, PendingDeprecationWarning, stacklevel=2)
        return cls, arguments
    from launcher.language.actions.event_actions import Log

    return Log, {**arguments, "level": parser.parse_substitution(level)}


def parse_shutdown(cls: type, entity: Entity, parser: Parser) -> Parsed:
    """`shutdown`; a reason without substitutions becomes a plain text."""
    _, arguments = parse_action(cls, entity, parser)
    reason = entity.get_attr("reason", optional=True)
    if reason:
        parts = parser.parse_substitution(reason)
        text = plain_text(parts)
        arguments["reason"] = parts if text is None else text
    return cls, arguments


_OF_TRACE = (
    "session-name snapshot-mode dual-session append-timestamp base-path append-trace events-ust "
    "events-kernel syscalls context-fields subbuffer-size-ust subbuffer-size-kernel"
)


def parse_trace(cls: type, entity: Entity, parser: Parser) -> Parsed:
    """`trace`, whose attributes are accepted and not used."""
    for name in _OF_TRACE.split():
        entity.get_attr(name, optional=True)
    return parse_action(cls, entity, parser)
