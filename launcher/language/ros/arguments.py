"""What ROS arguments on a command line say: parameters, remappings, the name of the node."""

from __future__ import annotations

from collections.abc import Iterable

from launcher.base.model.record import Record
from launcher.base.model.ros_arguments import PARAMETER, PARAMETER_FILE, ros_options
from launcher.base.model.spec import ParameterSource

_NAMES, _NAMESPACE = ("__node", "__name"), "__ns"


class RosArguments(Record):
    """The ROS arguments of one command line, in their order.

    `node_name` and `namespace` are those of rules that apply to every node of the process.
    """

    parameters: tuple[ParameterSource, ...] = ()
    remappings: tuple[tuple[str, str], ...] = ()
    node_name: str | None = None
    namespace: str | None = None


def ros_arguments(words: Iterable[str]) -> RosArguments:
    """The arguments behind `--ros-args`, up to `--` or the end; what is malformed is left out."""
    parameters: list[ParameterSource] = []
    remappings: list[tuple[str, str]] = []
    names: dict[str, str] = {}
    for option, value in ros_options(words):
        if option is PARAMETER_FILE:
            parameters.append(ParameterSource(file=value))
            continue
        left, separator, right = value.partition(":=")
        if not separator or not left:
            continue
        if option is PARAMETER:
            parameters.append(ParameterSource(rule=value))
        elif left in (*_NAMES, _NAMESPACE):
            names.setdefault(left, right)  # rcl takes the first rule that fits
        elif left.rpartition(":")[2] not in (*_NAMES, _NAMESPACE):  # of one node among several
            remappings.append((left, right))
    return RosArguments(
        parameters=tuple(parameters),
        remappings=tuple(remappings),
        node_name=next((names[key] for key in _NAMES if key in names), None),
        namespace=names.get(_NAMESPACE),
    )
