"""Parameters for a load request: dictionaries and parameter files as (name, value) pairs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from launcher.base import text_file
from launcher.base.model.parameter_sections import parameters_for, sections
from launcher.language.ros.parameter_values import (
    evaluate_parameter_dict,
    normalize_parameter_dict,
)

if TYPE_CHECKING:
    from launcher.language.context import LaunchContext

_NO_NAME = "_"  # `/*` matches it


def parameter_pairs(
    context: LaunchContext, node_name: str, namespace: str | None, evaluated: Iterable[Any]
) -> Iterator[tuple[str, object]]:
    """Pairs in order; of a file, the parameters for the node's full name.

    A service call cannot carry a file, so the file is read here, as in ROS 2.
    """
    node = full_name(node_name, namespace)
    values: object = {}
    for parameters in evaluated:
        if isinstance(parameters, Path):
            found = _from_file(parameters, node)
            if found:
                values = evaluate_parameter_dict(context, normalize_parameter_dict(found))
        else:
            values = parameters
        if not isinstance(values, dict):
            raise RuntimeError(f"invalid evaluated parameters {values!r}")
        yield from ((name, _without_mark(value)) for name, value in values.items())


def _without_mark(value: object) -> Any:
    """The value with `str` in place of ExponentText: a request has types."""
    if isinstance(value, tuple):
        return tuple(map(_without_mark, value))
    return str.__str__(value) if isinstance(value, str) else value


def full_name(node_name: str, namespace: str | None) -> str:
    """The name with its namespace."""
    # The plug-in chooses a name that is not given: only sections with wildcards can match.
    name = f"/{node_name.lstrip('/') or _NO_NAME}"
    if namespace and namespace != "/":
        return f"/{namespace.strip('/')}{name}"
    return name


def _from_file(path: Path, node: str) -> dict[str, Any]:
    from launcher.base.model.parameter_text import read

    content = read(text_file.read(path))
    if not isinstance(content, dict):
        raise RuntimeError(f"invalid yaml file {path}, error: it holds no parameters")
    known = list(sections(content))
    if not known:
        return content
    return {name: value for name, _, value in parameters_for(node, known)}


class ComponentValue(NamedTuple):
    """A parameter with the attributes of rclpy's; the launcher does not import rclpy."""

    name: str
    value: object


def to_parameters_list(
    context: LaunchContext, node_name: str, namespace: str, evaluated_parameters: Iterable[Any]
) -> list[ComponentValue]:
    """The parameters of a load request."""
    pairs = parameter_pairs(context, node_name, namespace, evaluated_parameters)
    return [ComponentValue(name, value) for name, value in pairs]
