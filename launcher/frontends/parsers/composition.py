"""`node_container`, `load_composable_node` and `composable_node`."""

from __future__ import annotations

from launcher.frontends.entity import Entity
from launcher.frontends.parsers.base import (
    ENTITIES,
    Parsed,
    add_texts,
    name_value_pairs,
    parse_action,
    parse_condition,
)
from launcher.frontends.parsers.node import parse_node, parse_parameters

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def parse_container(cls: Any, entity: Entity, parser: Any) -> Parsed:
    """`node_container`."""
    _, arguments = parse_node(cls, entity, parser)
    nested = entity.get_attr("composable_node", data_type=ENTITIES, optional=True)
    if nested is not None:
        arguments["composable_node_descriptions"] = _descriptions(nested, parser)
    return cls, arguments


def parse_load(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`load_composable_node`."""
    _, arguments = parse_action(cls, entity, parser)
    arguments["target_container"] = parser.parse_substitution(entity.get_attr("target"))
    nested = entity.get_attr("composable_node", data_type=ENTITIES)
    arguments["composable_node_descriptions"] = _descriptions(nested, parser)
    return cls, arguments


def _descriptions(entities: list[Entity], parser: Any) -> list[Any]:
    from launcher.language.ros.composition import ComposableNode

    parsed = [parse_composable_node(ComposableNode, parser, entity) for entity in entities]
    return [description(**arguments) for description, arguments in parsed]


def parse_composable_node(cls: type, parser: Any, entity: Entity) -> Parsed:
    """`composable_node`; unknown attributes are not looked for, as in ROS 2."""
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
