"""Reads and sets parameters of nodes, in the format of `ros2 param`."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rcl_interfaces.msg import Parameter, ParameterValue, SetParametersResult
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)

from launcher.base.ros_errors import VerbError, did_you_mean
from launcher.ros.parameter_values import NOT_SET, plain_value, type_for_words, type_name
from launcher.ros.service_caller import ServiceCaller

_UNDECLARED = "Invalid access to undeclared parameter(s): "  # the reason of rclpy


def prepare(caller: ServiceCaller, node: str) -> None:
    """Create the clients, which is slow, while the node is being discovered."""
    with contextlib.suppress(VerbError):  # an invalid name; the node will not be found
        caller.client(ListParameters, f"{node}/list_parameters")
        caller.client(GetParameters, f"{node}/get_parameters")


def list_names(caller: ServiceCaller, node: str, prefixes: list[str] | None = None) -> list[str]:
    request = ListParameters.Request(prefixes=prefixes or [])
    answer = caller.ask(ListParameters, f"{node}/list_parameters", request)
    return sorted(answer.result.names)


def describe(caller: ServiceCaller, node: str, names: list[str]) -> list[Any]:
    """The descriptors; VerbError for a name that the node does not have."""
    require_names(caller, node, names)
    return list(_descriptors(caller, node, names).values())


def require_names(caller: ServiceCaller, node: str, names: list[str]) -> None:
    """VerbError for the first name that the node does not have."""
    known = list_names(caller, node)
    for name in names:
        if name not in known:
            near = did_you_mean(name, known)
            raise VerbError(
                f"Parameter '{name}' not found on node '{node}'",
                hint=near or f"parameters: {', '.join(known)}",
            )


def get(caller: ServiceCaller, node: str, names: list[str]) -> list[Any]:
    """ParameterValues in the order of the names; fewer if a name is not declared."""
    request = GetParameters.Request(names=names)
    return list(caller.ask(GetParameters, f"{node}/get_parameters", request).values)


def values_of(caller: ServiceCaller, node: str, names: Sequence[str]) -> dict[str, Any]:
    """Name -> ParameterValue; one that is not declared or has no value is of the type NOT_SET."""
    found = known_values(caller, node, names)
    return {name: found.get(name) or ParameterValue() for name in names}


def known_values(caller: ServiceCaller, node: str, names: Sequence[str]) -> dict[str, Any]:
    """Name -> ParameterValue, of those for which the node answers."""
    found = _all_answers(names, lambda asked: get(caller, node, asked))
    return {name: value for name, value in found.items() if value is not None}


def answers(names: Sequence[str]) -> Generator[list[str], Sequence[Any], dict[str, Any]]:
    """Name -> what a node answers for it; None if there is nothing.

    Yields names to ask for, and is sent the answers. A node answers for none of several names if
    there is nothing for one of them: then each half is asked for.
    """
    if not names:
        return {}
    found = yield list(names)
    if len(found) == len(names):
        return dict(zip(names, found, strict=True))
    if len(names) == 1:
        return {names[0]: None}
    half = len(names) // 2
    return {**(yield from answers(names[:half])), **(yield from answers(names[half:]))}


def _all_answers(names: Sequence[str], ask: Callable[[list[str]], Sequence[Any]]) -> dict[str, Any]:
    asking = answers(names)
    try:
        asked = next(asking)
        while True:
            asked = asking.send(ask(asked))
    except StopIteration as end:
        found: dict[str, Any] = end.value
        return found


def documents(caller: ServiceCaller, node: str) -> list[dict[str, Any]]:
    """Descriptions and values of all parameters that a node has now, sorted by name."""
    descriptors = _descriptors(caller, node, list_names(caller, node))
    values = values_of(caller, node, list(descriptors))
    return [_document(descriptors[name], value) for name, value in values.items()]


def _document(descriptor: Any, value: Any) -> dict[str, Any]:
    return {
        "name": descriptor.name,
        "type": type_name(value.type or descriptor.type),
        "value": plain_value(value),
        "description": descriptor.description,
        "read_only": descriptor.read_only,
        "additional_constraints": descriptor.additional_constraints,
        "integer_range": _range(descriptor.integer_range),
        "floating_range": _range(descriptor.floating_point_range),
    }


def _range(ranges: Any) -> dict[str, Any] | None:
    """The first of at most one; a step of 0 means any value."""
    for limits in ranges:
        return {"from": limits.from_value, "to": limits.to_value, "step": limits.step}
    return None


def descriptor_lines(descriptor: Any) -> Iterator[str]:
    yield f"Parameter name: {descriptor.name}"
    yield f"  Type: {type_name(descriptor.type)}"
    if descriptor.description:
        yield f"  Description: {descriptor.description}"
    yield "  Constraints:"
    if descriptor.read_only:
        yield "    Read only: true"
    for limits in [*descriptor.floating_point_range, *descriptor.integer_range][:1]:
        yield f"    Min value: {limits.from_value}"
        yield f"    Max value: {limits.to_value}"
        if limits.step:
            yield f"    Step: {limits.step}"
    if descriptor.additional_constraints:
        yield f"    Additional constraints: {descriptor.additional_constraints}"


def declared_types(
    caller: ServiceCaller,
    node: str,
    names: Sequence[str],
    type_for: Callable[[Any], int] = lambda descriptor: descriptor.type,
) -> dict[str, int]:
    """Name -> type number of those names that the node has, by their descriptors."""
    found = _descriptors(caller, node, names)
    return {name: type_for(descriptor) for name, descriptor in found.items()}


def _descriptors(caller: ServiceCaller, node: str, names: Sequence[str]) -> dict[str, Any]:
    """Name -> descriptor of those names that the node has."""

    def ask(asked: list[str]) -> Sequence[Any]:
        request = DescribeParameters.Request(names=asked)
        service = f"{node}/describe_parameters"
        return list(caller.ask(DescribeParameters, service, request).descriptors)

    found = _all_answers(names, ask)
    return {name: descriptor for name, descriptor in found.items() if descriptor is not None}


class SetOutcome(NamedTuple):
    """Of setting a parameter: its message, None if there can be none, and the node's result."""

    message: Any
    result: Any


def set_values(
    caller: ServiceCaller,
    node: str,
    values: Mapping[str, Any],
    make: Callable[[str, Any, int], Any],
    type_for: Callable[[Any], int] = type_for_words,
) -> dict[str, SetOutcome]:
    """Set all of them; one that is refused does not keep the others from being set.

    `make` gets a name, a value and the type for it by `type_for`, and returns a Parameter message,
    or raises VerbError.
    """
    types = declared_types(caller, node, list(values), type_for)
    messages: dict[str, Any] = {}
    outcomes: dict[str, SetOutcome] = {}
    for name, value in values.items():
        try:
            messages[name] = make(name, value, types.get(name, NOT_SET))
        except VerbError as error:
            reason = f"{error.message} ({error.hint})" if error.hint else error.message
            outcomes[name] = SetOutcome(None, SetParametersResult(reason=reason))
    results = set_all(caller, node, list(messages.values()))
    for (name, message), result in zip(messages.items(), results, strict=True):
        outcomes[name] = SetOutcome(message, result)
    return {name: outcomes[name] for name in values}


def set_all(caller: ServiceCaller, node: str, parameters: list[Any]) -> list[Any]:
    """A result for each."""
    if not parameters:
        return []
    request = SetParameters.Request(parameters=parameters)
    answer = caller.call(SetParameters, f"{node}/set_parameters", request)
    results = results_of(answer, len(parameters))
    return [named(one, [sent.name]) for one, sent in zip(results, parameters, strict=True)]


def named(result: Any, undeclared: Sequence[str]) -> Any:
    """A result whose reason names these parameters; rclpy lists only the last of them, or none."""
    if result.reason.startswith(_UNDECLARED) and undeclared:
        result.reason = f"{_UNDECLARED}{list(undeclared)}"
    return result


def results_of(answer: Any, count: int) -> list[Any]:
    """The results of `count` parameters, of which the node may have judged fewer."""
    missing = SetParametersResult(reason="the node has not answered for it")
    return [*answer.results, *([missing] * count)][:count]


def delete(caller: ServiceCaller, node: str, name: str) -> Any:
    """The node's verdict; VerbError for a name that it does not have."""
    require_names(caller, node, [name])
    unset = Parameter(name=name, value=ParameterValue(type=NOT_SET))
    return set_all(caller, node, [unset])[0]


def set_atomically(caller: ServiceCaller, node: str, parameters: list[Any]) -> Any:
    request = SetParametersAtomically.Request(parameters=parameters)
    return caller.call(SetParametersAtomically, f"{node}/set_parameters_atomically", request).result
