"""Requests to load a component, as the messages of ROS 2."""

from __future__ import annotations

import importlib
from collections.abc import Iterable
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from launcher.base.model.events import LoadRequest

# Type of the first value -> (field of ParameterValue, constant of ParameterType).
_SCALARS = {
    bool: ("bool_value", 1),
    int: ("integer_value", 2),
    float: ("double_value", 3),
    str: ("string_value", 4),
    bytes: ("byte_array_value", 5),
}
_ARRAYS = {
    bool: ("bool_array_value", 6),
    int: ("integer_array_value", 7),
    float: ("double_array_value", 8),
    str: ("string_array_value", 9),
    bytes: ("byte_array_value", 5),
}
_ZERO: dict[str, Any] = {
    "type": 0,
    "bool_value": False,
    "integer_value": 0,
    "double_value": 0.0,
    "string_value": "",
}


def ros_request(request: LoadRequest) -> Any:
    """A `composition_interfaces.srv.LoadNode.Request`; its shape where that is not installed."""
    fields = {
        "package_name": request.package,
        "plugin_name": request.plugin,
        "node_name": request.name,
        "node_namespace": request.namespace,
        "log_level": 0,
        "remap_rules": [f"{source}:={target}" for source, target in request.remappings],
        "parameters": _parameters(request.parameters),
        "extra_arguments": _parameters(request.extra_arguments),
    }
    return _message("composition_interfaces.srv", "LoadNode", "Request", **fields)


def _parameters(pairs: Iterable[tuple[str, object]]) -> list[Any]:
    return [
        _message("rcl_interfaces.msg", "Parameter", name=name, value=_value(value))
        for name, value in pairs
    ]


def _value(value: object) -> Any:
    if isinstance(value, (list, tuple)):
        field, number = _ARRAYS[type(value[0]) if value else bytes]
        value = list(value)
    else:
        field, number = _SCALARS[type(value)]
    if isinstance(value, bytes):
        value = [bytes([one]) for one in value]
    fields = {**_ZERO, **{name: [] for name, _ in _ARRAYS.values()}}
    return _message(
        "rcl_interfaces.msg", "ParameterValue", **{**fields, "type": number, field: value}
    )


def _message(module: str, *names: str, **fields: Any) -> Any:
    try:
        made: Any = importlib.import_module(module)
    except ImportError:
        return SimpleNamespace(**fields)
    for name in names:
        made = getattr(made, name)
    return made(**fields)
