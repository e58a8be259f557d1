"""Reads and sets parameters of nodes, in the format of `ros2 param`."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import yaml
from rcl_interfaces.msg import Parameter, ParameterValue, SetParametersResult
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)

from launcher.base import text_file, yaml_bounds
from launcher.base.model.parameter_sections import PARAMETERS, parameters_for, sections
from launcher.base.model.parameter_text import rcl_loader, word_value
from launcher.base.ros_errors import VerbError, did_you_mean
from launcher.ros.messages.from_yaml import TEXTS, shown, value_of
from launcher.ros.service_caller import ServiceCaller


class ParameterKind(NamedTuple):
    """The field of ParameterValue, the name of the type, and the label of `param get`."""

    field: str
    name: str
    label: str


# By the number of ParameterType.
KINDS = {
    1: ParameterKind("bool_value", "boolean", "Boolean value is:"),
    2: ParameterKind("integer_value", "integer", "Integer value is:"),
    3: ParameterKind("double_value", "double", "Double value is:"),
    4: ParameterKind("string_value", "string", "String value is:"),
    5: ParameterKind("byte_array_value", "byte array", "Byte values are:"),
    6: ParameterKind("bool_array_value", "boolean array", "Boolean values are:"),
    7: ParameterKind("integer_array_value", "integer array", "Integer values are:"),
    8: ParameterKind("double_array_value", "double array", "Double values are:"),
    9: ParameterKind("string_array_value", "string array", "String values are:"),
}
NOT_SET, BOOL, INTEGER, DOUBLE, STRING = 0, 1, 2, 3, 4
BYTES, BOOLS, INTEGERS, DOUBLES, STRINGS = 5, 6, 7, 8, 9
_INT64 = (-(2**63), 2**63 - 1)
_WHOLE = f"a whole number is from {_INT64[0]} to {_INT64[1]}"
# hints for values of the right kind that do not fit
_LIMITS = {
    INTEGER: _WHOLE,
    INTEGERS: _WHOLE,
    DOUBLE: "a double is at most 1.8e308",
    DOUBLES: "a double is at most 1.8e308",
    BYTES: "a byte is from 0 to 255",
    STRING: "a number of thousands of digits cannot be a string",
}


class NoKindError(VerbError):
    """The value is of a type that parameters do not have."""


def type_name(number: int) -> str:
    return KINDS[number].name if number in KINDS else "not set"


def plain_value(value: Any) -> Any:
    """The value of a ParameterValue; None if it is not set."""
    if value.type not in KINDS:
        return None
    held = getattr(value, KINDS[value.type].field)
    if value.type == BYTES:
        return [byte[0] for byte in held]
    return list(held) if value.type > STRING else held


def value_text(value: Any, *, hide_type: bool) -> str:
    if value.type not in KINDS:
        return "None" if hide_type else "Parameter not set."
    kind = KINDS[value.type]
    held = getattr(value, kind.field)
    held = held.tolist() if hasattr(held, "tolist") else held  # an array prints its typecode, too
    return str(held) if hide_type else f"{kind.label} {held}"


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
    found = _all_answers(names, lambda asked: get(caller, node, asked))
    return {name: value or ParameterValue() for name, value in found.items()}


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


def parameter(name: str, value: object, declared_type: int = NOT_SET) -> Any:
    """A Parameter message; an integer becomes a double where one is declared.

    NoKindError if parameters cannot have such a value, VerbError if it is too large.
    """
    kind = _kind_of(value, declared_type)
    if kind is None:
        raise NoKindError(
            f"Parameter '{name}' cannot hold {shown(value)}",
            hint="a parameter is a boolean, number, string, or a list of one of these",
        )
    held = ParameterValue(type=kind)
    try:
        setattr(held, KINDS[kind].field, _cast(value, kind))
    except (ValueError, OverflowError):
        raise VerbError(
            f"Parameter '{name}' cannot hold {shown(value)}", hint=_LIMITS[kind]
        ) from None
    return Parameter(name=name, value=held)


def _kind_of(value: object, declared: int) -> int | None:
    if isinstance(value, list):
        return _list_kind(value, declared)
    kinds = {bool: BOOL, int: INTEGER, float: DOUBLE, str: STRING, bytes: BYTES}
    found = kinds.get(type(value))
    if found == INTEGER and declared == DOUBLE:
        return DOUBLE
    return STRING if found not in (None, BYTES) and declared == STRING else found


def _list_kind(values: list[Any], declared: int) -> int | None:
    kinds = {_kind_of(value, NOT_SET) for value in values}
    if not kinds:
        return declared if declared > STRING else STRINGS
    if kinds == {INTEGER} and declared in (DOUBLES, BYTES):
        return declared
    if kinds == {INTEGER, DOUBLE}:
        return DOUBLES
    lists = {BOOL: BOOLS, INTEGER: INTEGERS, DOUBLE: DOUBLES, STRING: STRINGS, BYTES: BYTES}
    return lists.get(kinds.pop() or NOT_SET) if len(kinds) == 1 else None


def _cast(value: Any, kind: int) -> Any:
    if kind == BYTES and isinstance(value, list) and any(isinstance(one, bytes) for one in value):
        value = b"".join(value)  # `ros2 param dump` writes each byte as a `!!binary` of its own
    if kind > STRING:
        return [_cast_one(item, kind) for item in value]
    return _cast_one(value, kind)


def _cast_one(value: Any, kind: int) -> Any:
    if kind in (INTEGER, INTEGERS) and not _INT64[0] <= value <= _INT64[1]:
        raise OverflowError
    if kind in (DOUBLE, DOUBLES):
        return float(value)
    if kind == BYTES:
        return bytes([value])
    return str(value) if kind == STRING else value


class Written(NamedTuple):
    """A value that was written as YAML, with the types of rcl, and the same with texts only."""

    value: Any
    words: object


def written_parameter(name: str, given: Written, declared_type: int = NOT_SET) -> Any:
    """A Parameter message from a file; its words are texts where texts are declared."""
    is_text = declared_type in (STRING, STRINGS)
    return parameter(name, given.words if is_text else given.value, declared_type)


def typed_parameter(name: str, word: str, declared_type: int = NOT_SET) -> Any:
    """A Parameter from a word of the command line, a string if it is nothing else."""
    if declared_type == STRING:
        return parameter(name, word, STRING)
    try:
        given = Written(value_of(word, rcl_loader()), value_of(word, TEXTS))
        return written_parameter(name, given, declared_type)
    except (yaml.YAMLError, NoKindError):
        return parameter(name, word)


def plain_parameter(name: str, value: object, declared_type: int = NOT_SET) -> Any:
    """A Parameter from JSON; a text is a word where a number is declared."""
    if isinstance(value, str) and declared_type in (INTEGER, DOUBLE):
        value = word_value(value)
    return parameter(name, value, declared_type)


def type_for_words(descriptor: Any) -> int:
    """The type that a value of YAML is made to fit; NOT_SET if the parameter may change it."""
    return NOT_SET if descriptor.dynamic_typing else descriptor.type


def type_for_json(descriptor: Any) -> int:
    """The type that a value of JSON is made to fit, also if the parameter may change it.

    JSON of a browser has one kind of numbers: `5` for a double is one. A number is a text only
    where the type is fixed.
    """
    is_changed = descriptor.dynamic_typing and descriptor.type == STRING
    return NOT_SET if is_changed else descriptor.type


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
    return results_of(answer, len(parameters))


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


def dump_document(node: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """The parameter file of a node; dots in names become levels, if there is no such parameter."""
    tree: dict[str, Any] = {}
    for name in sorted(values):
        branch, rest = tree, name
        while "." in rest and isinstance(branch.get(rest.partition(".")[0], {}), dict):
            group, _, rest = rest.partition(".")
            branch = branch.setdefault(group, {})
        branch[rest] = values[name]
    return {node: {"ros__parameters": tree}}


def file_values(path: str, node: str, *, use_wildcard: bool) -> dict[str, Written]:
    """Name -> value for a node from a parameter file; VerbError if it has none for it."""
    text = _text(path)
    values, words = (
        _of_node(_tree(text, loader, path), path, node, use_wildcard=use_wildcard)
        for loader in (rcl_loader(), TEXTS)
    )
    return {name: Written(value, words.get(name)) for name, value in values.items()}


def _of_node(document: object, path: str, node: str, *, use_wildcard: bool) -> dict[str, Any]:
    try:
        known = list(sections(document))
        usable = [one for one in known if one.is_exact or use_wildcard]
        own = [one for one in usable if one.is_for(node)]
        for one in own:
            if one.parameters not in (None, "") and not isinstance(one.parameters, Mapping):
                where = f"'{PARAMETERS}' of '{one.selector}'"
                raise VerbError(f"{path}: expected names of parameters below {where}")
        if own:
            return {name: value for name, _, value in parameters_for(node, own)}
    except RecursionError:
        raise VerbError(f"{path}: a section contains itself") from None
    if not known and document:
        raise VerbError(f"{path}: expected '{PARAMETERS}' below the name of the node")
    names = [one.selector for one in known]
    near = did_you_mean(node, names)
    hint = f"it is for: {', '.join(names) or 'nothing'}" + (f"; {near}" if near else "")
    if not use_wildcard and any(one.is_for(node) for one in known):
        hint += "; without --no-use-wildcard, what is below a wildcard is taken"
    raise VerbError(f"Param file does not contain parameters for {node}", hint=hint)


def _text(path: str) -> str:
    try:
        text = text_file.read(path)
    except (OSError, ValueError) as error:
        raise VerbError(f"{path}: {getattr(error, 'strerror', None) or error}") from None
    if text_file.is_pointer(text):
        raise VerbError(text_file.pointer_sentence(path), hint=text_file.POINTER_HINT)
    return text


def _tree(text: str, loader: object, path: str) -> dict[str, Any]:
    try:
        document = value_of(text, loader)
    except yaml.YAMLError as error:
        raise VerbError(yaml_bounds.sentence(error, path)) from None
    if not isinstance(document, dict):
        raise VerbError(f"{path}: expected names of nodes at the top")
    return document
