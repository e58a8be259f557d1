"""Parse functions of nodes, containers and composable nodes."""

from __future__ import annotations

from collections.abc import Iterable

from launcher.language.frontends.entity import Entity, get_data_type_from_identifier
from launcher.language.frontends.errors import (
    AttributeTypeError,
    StructureError,
    UnexpectedContentError,
    shown,
)
from launcher.language.frontends.parsers.attributes import (
    ENTITIES,
    Parsed,
    add_texts,
    name_value_pairs,
    parse_action,
    parse_condition,
)
from launcher.language.frontends.parsers.process import parse_process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.frontends.parser import Parser

# Keyword of the constructor -> attribute.
_TEXTS = {
    "name": "name",
    "exec_name": "exec_name",
    "package": "pkg",
}
_WORDS = {"arguments": "args", "ros_arguments": "ros_args"}


def parse_node(cls: Any, entity: Entity, parser: Any) -> Parsed:
    """`node`."""
    _, arguments = parse_process(cls, entity, parser, ["cmd", "name"])
    for keyword, attribute in _WORDS.items():
        text = entity.get_attr(attribute, optional=True)
        if text is not None:
            arguments[keyword] = cls._parse_cmdline(text, parser)
    if entity.get_attr("node-name", optional=True) is not None:
        message = "<node> no longer takes 'node-name'"
        raise AttributeTypeError(message, place=entity.place, hint="use 'name'")
    add_texts(arguments, entity, parser, _TEXTS, optional=True)
    add_texts(arguments, entity, parser, {"executable": "exec"}, optional=False)
    add_texts(arguments, entity, parser, {"namespace": "namespace"}, optional=True)
    remappings = name_value_pairs(entity, parser, "remap", names=("from", "to"))
    if remappings is not None:
        arguments["remappings"] = remappings
    parameters = entity.get_attr("param", data_type=ENTITIES, optional=True)
    if parameters is not None:
        arguments["parameters"] = cls.parse_nested_parameters(parameters, parser)
    return cls, arguments


def parse_lifecycle_node(cls: Any, entity: Entity, parser: Parser) -> Parsed:
    """`lifecycle_node`."""
    _, arguments = parse_node(cls, entity, parser)
    _add_truth(arguments, entity, parser, "autostart", optional=True)
    return cls, arguments


def parse_use_sim_time(cls: type, entity: Entity, parser: Parser) -> Parsed:
    """`set_use_sim_time`."""
    _, arguments = parse_action(cls, entity, parser)
    _add_truth(arguments, entity, parser, "value", optional=False)
    return cls, arguments


def _add_truth(
    arguments: dict[str, Any], entity: Entity, parser: Parser, name: str, *, optional: bool
) -> None:
    """Add a truth value, or substitutions that yield one."""
    given = entity.get_attr(name, data_type=bool, optional=optional)
    if given is None:
        return
    arguments[name] = value = parser.parse_if_substitutions(given)
    if isinstance(value, str):
        message = f"'{name}' should be true, false or a substitution, not '{shown(value)}'"
        raise AttributeTypeError(message, place=entity.place)


def parse_parameters(cls: type, params: Iterable[Entity], parser: Parser) -> list[Any]:
    """Parameter files and dictionaries, one for each `param`, in order."""
    return [_file_or_dictionary(param, parser) for param in params]


def _file_or_dictionary(param: Entity, parser: Parser) -> Any:
    file = param.get_attr("from", optional=True)
    allow_substs = param.get_attr("allow_substs", data_type=bool, optional=True)
    name = param.get_attr("name", optional=True)
    if file is not None and name is not None:
        raise StructureError("'name' and 'from' exclude each other", place=param.place)
    if file is not None:
        return _parameter_file(param, parser, file, allow_substs)
    if name is None:
        message = "a parameter needs a 'name', or 'from' with a file"
        raise UnexpectedContentError(message, place=param.place)
    if allow_substs is not None:
        message = "'allow_substs' requires 'from'"
        raise StructureError(message, place=param.place)
    return _dictionary([param], parser)


def _parameter_file(param: Entity, parser: Parser, file: str, allow_substs: object) -> Any:
    from launcher.language.ros.parameter_descriptions import ParameterFile

    allowed = (
        parser.parse_substitution(allow_substs)
        if isinstance(allow_substs, str)
        else bool(allow_substs)
    )
    param.assert_entity_completely_parsed()
    return ParameterFile(parser.parse_substitution(file), allow_substs=allowed)


def _dictionary(params: Iterable[Entity], parser: Parser) -> dict[Any, Any]:
    """The values of parameters, those of nested parameters in nested dictionaries."""
    values: dict[Any, Any] = {}
    for param in params:
        name = tuple(parser.parse_substitution(param.get_attr("name")))
        data_type = _data_type(param)
        value = param.get_attr("value", data_type=data_type, optional=True)
        nested = param.get_attr("param", data_type=ENTITIES, optional=True)
        param.assert_entity_completely_parsed()
        _check_shape(param, value, nested, data_type)
        values[name] = (
            _dictionary(nested, parser) if nested else _value(param, value, data_type, parser)
        )
    return values


def _data_type(param: Entity) -> Any:
    identifier = param.get_attr("type", data_type=None, optional=True)
    if identifier is None:
        return None
    return get_data_type_from_identifier(identifier)


def _check_shape(param: Entity, value: object, nested: object, data_type: object) -> None:
    if nested and (value is not None or data_type is not None):
        message = "a parameter with nested parameters cannot have a 'value' or 'type'"
        raise StructureError(message, place=param.place)
    if value is None and not nested:
        message = "a parameter needs a 'value' or nested parameters"
        raise StructureError(message, place=param.place)


def _value(param: Entity, value: object, data_type: object, parser: Parser) -> Any:
    from launcher.language.ros.parameter_descriptions import ParameterValue

    try:
        some_value = parser.parse_if_substitutions(value)
    except ValueError as problem:
        raise UnexpectedContentError(str(problem), place=param.place) from problem
    return ParameterValue(some_value, value_type=data_type)


def parse_container(cls: Any, entity: Entity, parser: Parser) -> Parsed:
    """`node_container`."""
    _, arguments = parse_node(cls, entity, parser)
    descriptions = _descriptions(entity, parser)
    if descriptions:
        arguments["composable_node_descriptions"] = descriptions
    return cls, arguments


def parse_load(cls: type, entity: Entity, parser: Parser) -> Parsed:
    """`load_composable_node`."""
    _, arguments = parse_action(cls, entity, parser)
    arguments["target_container"] = parser.parse_substitution(entity.get_attr("target"))
    descriptions = _descriptions(entity, parser)
    if not descriptions:
        message = (
            f"<{entity.type_name}> needs a nested tag <composable_node> or "
            "<composable_lifecycle_node>"
        )
        raise StructureError(message, place=entity.place)
    arguments["composable_node_descriptions"] = descriptions
    return cls, arguments


def _descriptions(entity: Entity, parser: Parser) -> list[Any]:
    """The nested nodes; as in ROS 2, lifecycle nodes come last."""
    from launcher.language.ros.composition import ComposableNode

    plain = entity.get_attr("composable_node", data_type=ENTITIES, optional=True) or ()
    others = entity.get_attr("composable_lifecycle_node", data_type=ENTITIES, optional=True) or ()
    found: list[tuple[Any, Entity]] = [(ComposableNode, one) for one in plain]
    if others:
        from launcher.language.ros.composable_lifecycle import ComposableLifecycleNode

        found += [(ComposableLifecycleNode, one) for one in others]
    made = []
    for kind, one in found:
        description, arguments = kind.parse(parser, one)
        one.assert_entity_completely_parsed()
        made.append(description(**arguments))
    return made


def parse_composable_lifecycle_node(cls: type, parser: Parser, entity: Entity) -> Parsed:
    """`composable_lifecycle_node`."""
    _, arguments = parse_composable_node(cls, parser, entity)
    _add_truth(arguments, entity, parser, "autostart", optional=True)
    return cls, arguments


def parse_composable_node(cls: type, parser: Parser, entity: Entity) -> Parsed:
    """`composable_node`."""
    arguments: dict[str, Any] = {}
    add_texts(arguments, entity, parser, {"package": "pkg", "plugin": "plugin"}, optional=False)
    texts = {"name": "name", "namespace": "namespace"}
    add_texts(arguments, entity, parser, texts, optional=True)
    condition = parse_condition(entity, parser)
    if condition is not None:
        arguments["condition"] = condition
    parameters = entity.get_attr("param", data_type=ENTITIES, optional=True)
    if parameters is not None:
        arguments["parameters"] = parse_parameters(cls, parameters, parser)
    remappings = name_value_pairs(entity, parser, "remap", names=("from", "to"))
    if remappings is not None:
        arguments["remappings"] = remappings
    extra = name_value_pairs(entity, parser, "extra_arg")
    if extra is not None:
        arguments["extra_arguments"] = [{tuple(name): value} for name, value in extra]
    return cls, arguments
