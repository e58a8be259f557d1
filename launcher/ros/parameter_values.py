"""Values of parameters: their types, texts, and the messages that carry them."""

from __future__ import annotations

from typing import Any, NamedTuple

import yaml
from rcl_interfaces.msg import Parameter, ParameterValue

from launcher.base.model.parameter_text import rcl_loader, word_value
from launcher.base.ros_errors import VerbError
from launcher.ros.messages.from_yaml import TEXTS, shown, value_of


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


def unset() -> Any:
    """The value of a parameter that has none."""
    return ParameterValue()


def document(name: str, value: Any) -> dict[str, Any]:
    """A parameter for JSON."""
    return {"name": name, "type": type_name(value.type), "value": plain_value(value)}


def value_text(value: Any, *, hide_type: bool) -> str:
    if value.type not in KINDS:
        return "None" if hide_type else "Parameter not set."
    kind = KINDS[value.type]
    held = getattr(value, kind.field)
    held = held.tolist() if hasattr(held, "tolist") else held  # an array prints its typecode, too
    return str(held) if hide_type else f"{kind.label} {held}"


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
        value = b"".join(value)  # `ros2 param dump` writes each byte as a separate `!!binary`
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
