"""What ROS arguments on a command line say: parameters, remappings, the name of the node."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from launcher.model.record import Record
from launcher.model.spec import ParameterSource

# Flags with a word behind them; all others have none.
_PARAMETER = ("-p", "--param")
_REMAP = ("-r", "--remap")
_FILE = "--params-file"
_WITH_VALUE = (
    *_PARAMETER,
    *_REMAP,
    _FILE,
    "--log-level",
    "--log-config-file",
    "--log-file-name",
    "-e",
    "--enclave",
)
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
    for flag, value in _flags(words):
        if flag == _FILE:
            parameters.append(ParameterSource(file=value))
            continue
        left, separator, right = value.partition(":=")
        if not separator or not left or flag not in (*_PARAMETER, *_REMAP):
            continue
        if flag in _PARAMETER:
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


def _flags(words: Iterable[str]) -> Iterator[tuple[str, str]]:
    """(flag, value) of the flags with a value."""
    is_ros = False
    flag: str | None = None
    for word in words:
        if flag is not None:
            yield flag, word
            flag = None
        elif word == "--ros-args":
            is_ros = True
        elif word == "--":
            is_ros = False
        elif is_ros and word in _WITH_VALUE:
            flag = word
