"""What changes the nodes that follow: namespace, remappings, parameters, log folder."""

from __future__ import annotations

from launcher.frontends.entity import Entity
from launcher.frontends.parsers.base import Parsed, parse_texts

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def parse_namespace(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`push_ros_namespace`, also spelled `push-ros-namespace`."""
    return parse_texts(cls, entity, parser, {"namespace": "namespace"})


def parse_remap(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`set_remap`."""
    return parse_texts(cls, entity, parser, {"src": "from", "dst": "to"})


def parse_set_parameter(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`set_parameter`."""
    return parse_texts(cls, entity, parser, {"name": "name", "value": "value"})


def parse_parameters_from_file(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`set_parameters_from_file`."""
    return parse_texts(cls, entity, parser, {"filename": "filename"})


def parse_log_dir(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`set_ros_log_dir`."""
    return parse_texts(cls, entity, parser, {"new_log_dir": "new_log_dir"})


def parse_use_sim_time(cls: type, entity: Entity, parser: Any) -> Parsed:
    """`set_use_sim_time`; its value stays a text, so ROS 2 fails when it is visited."""
    return parse_texts(cls, entity, parser, {"value": "value"})
