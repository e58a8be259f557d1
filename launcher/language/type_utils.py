"""Type checks of values, and conversion of texts by YAML's rules."""

from __future__ import annotations

from collections.abc import Iterable

from launcher.language.class_tools import ensure_argument_type
from launcher.language.substitution import (
    Substitution,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext

ScalarTypesTuple = (int, float, bool, str)


def is_typing_list(data_type: object) -> bool:
    """Whether it is `typing.List` or `typing.List[...]`."""
    if getattr(data_type, "__origin__", None) is not list:
        return False
    return bool(getattr(data_type, "__args__", True))


def is_valid_scalar_type(data_type: object) -> bool:
    return data_type in ScalarTypesTuple


def extract_type(data_type: object) -> tuple[Any, bool]:
    """(scalar type, whether it is a list of it); ValueError for anything else."""
    is_list = is_typing_list(data_type)
    scalar = data_type.__args__[0] if is_list and hasattr(data_type, "__args__") else data_type
    if not is_valid_scalar_type(scalar):
        raise ValueError(f"Unrecognized data type: {data_type}")
    return scalar, is_list


def is_instance_of_valid_type(value: object, can_be_str: bool = False) -> bool:
    """Whether it is a scalar or a uniform list; with `can_be_str`, texts may be mixed in."""
    if not isinstance(value, list):
        return isinstance(value, ScalarTypesTuple)
    kinds = {str if isinstance(item, str) else type(item) for item in value}
    if can_be_str and len(kinds) == 2:
        kinds.discard(str)
    return not kinds or (len(kinds) == 1 and kinds.pop() in ScalarTypesTuple)


def is_instance_of(value: object, data_type: object = None, can_be_str: bool = False) -> bool:
    """Whether the value is of the type; with None, of any allowed type."""
    if data_type is None:
        return is_instance_of_valid_type(value, can_be_str)
    scalar, is_list = extract_type(data_type)
    allowed = (str, scalar) if can_be_str else (scalar,)
    if not is_list:
        return isinstance(value, allowed)
    return isinstance(value, list) and all(isinstance(item, allowed) for item in value)


def _load_yaml(value: str, message: str, can_be_str: bool) -> Any:
    if not value:
        return value  # YAML would make None of it
    import yaml

    from launcher.base.model.parameter_text import value_of

    try:
        output = value_of(value)
    except (yaml.YAMLError, ValueError, TypeError, RecursionError) as error:
        if can_be_str:
            return value
        raise ValueError(f"{message}: yaml.safe_load() failed\n{error}") from error
    if not is_instance_of_valid_type(output, can_be_str):
        raise ValueError(f"{message}: output type is not allowed, got {type(output)}")
    return output


def coerce_to_type(value: str, data_type: object = None, can_be_str: bool = False) -> Any:
    """Convert a text to the type; ValueError if that fails, but with `can_be_str` the text."""
    ensure_argument_type(value, str, "value", "coerce_to_type")
    if data_type is None:
        return _load_yaml(value, f"Failed to convert '{value}' using yaml rules", can_be_str)
    scalar, is_list = extract_type(data_type)
    allowed = (str, scalar) if can_be_str else (scalar,)
    if is_list:
        return _coerce_to_list(value, allowed, can_be_str)
    if scalar is str:
        return value
    if scalar is bool:
        value = {"1": "true", "0": "false"}.get(value, value)
        output = _load_yaml(value, f"Failed to convert '{value}' to '{scalar}'", can_be_str)
        if isinstance(output, allowed):
            return output
        raise ValueError(f"Cannot convert value '{value}' to '{scalar}'")
    try:
        return scalar(value)
    except ValueError:
        if can_be_str:
            return value
        raise


def _coerce_to_list(value: str, allowed: tuple[type, ...], can_be_str: bool) -> Any:
    message = f"Cannot convert value '{value}' to a list of '{allowed}'"
    output = _load_yaml(value, message, can_be_str)
    if not isinstance(output, list):
        raise ValueError(message)
    if not all(isinstance(item, allowed) for item in output):
        raise ValueError(f"{message}, got {output}")
    return output


def coerce_list(value: list[str], data_type: object = None, can_be_str: bool = False) -> Any:
    """A list of texts as a uniform list of values of the type."""
    ensure_argument_type(value, list, "value", "coerce_list")
    output = [coerce_to_type(item, data_type, can_be_str) for item in value]
    if not is_instance_of_valid_type(output, can_be_str):
        raise ValueError(f"cannot convert value to {data_type}. Got value=`{value}`")
    return output


def get_typed_value(value: Any, data_type: Any, can_be_str: bool = False) -> Any:
    """A text, or a list of texts, as a value of the type."""
    if not isinstance(value, list):
        return coerce_to_type(value, data_type, can_be_str)
    if data_type is not None:
        data_type, is_list = extract_type(data_type)
        if not is_list:
            raise TypeError(
                f"Cannot convert input '{value}' of type '{type(value)}' to '{data_type}'"
            )
    return coerce_list(value, data_type, can_be_str)


def is_substitution(x: object) -> bool:
    """Whether it is a substitution, or texts and substitutions with at least one of these."""
    if isinstance(x, Substitution):
        return True
    if not isinstance(x, Iterable) or not len(x) > 0:  # type: ignore[arg-type]
        return False
    return all(isinstance(item, (Substitution, str)) for item in x) and any(
        isinstance(item, Substitution) for item in x
    )


def normalize_typed_substitution(value: object, data_type: object) -> Any:
    """A value of the type, or substitutions that will become one; TypeError if it cannot.

    Lists of substitutions inside of a list are kept apart: `[['a', sub], 'b']` has two items.
    """
    if isinstance(value, ScalarTypesTuple):
        if not is_instance_of(value, data_type):
            raise TypeError(f"value='{value}' is not an instance of {data_type}")
        return value
    if is_substitution(value):
        return normalize_to_list_of_substitutions(value)
    if not isinstance(value, Iterable):
        raise TypeError(
            "value should be either a scalar, a substitutions, or a mixed list of scalars and "
            f"substitutions. Got `value={value}` of type `{type(value)}`. "
        )
    items = list(value)
    kinds = _kinds(value, items)
    scalar = _expected_scalar(value, data_type)
    kinds.discard(Substitution)
    found = float if kinds == {int, float} else next(iter(kinds), None)
    if len(kinds) > 1 and found is not float:
        raise TypeError(f"Input value is not an acceptable 'SomeValueType'.Got value='{value}'")
    if found is not None and scalar not in (None, found):
        raise TypeError(f"Got a list of '{found}', expected a list of '{scalar}'. value='{value}'")
    convert = float if found is float else lambda item: item
    return [
        normalize_to_list_of_substitutions(item) if is_substitution(item) else convert(item)
        for item in items
    ]


def _kinds(value: object, items: list[Any]) -> set[type]:
    kinds: set[type] = set()
    for item in items:
        if isinstance(item, ScalarTypesTuple):
            kinds.add(str if isinstance(item, str) else type(item))
        elif is_substitution(item):
            kinds.add(Substitution)
        else:
            raise TypeError(
                "value is a list, and one of the items is not a scalar, a Substitution "
                f"or a list of substitutions. Got value='{value}'"
            )
    return kinds


def _expected_scalar(value: object, data_type: object) -> Any:
    if data_type is None:
        return None
    scalar, is_list = extract_type(data_type)
    if not is_list:
        raise TypeError(
            "The provided value resolves to a list, though the required type is a scalar. "
            f"Got value='{value}', data_type='{data_type}'."
        )
    return scalar


def is_normalized_substitution(value: object) -> bool:
    """Whether it is a list of substitutions only, with at least one."""
    return (
        isinstance(value, list)
        and len(value) > 0
        and all(isinstance(item, Substitution) for item in value)
    )


def perform_typed_substitution(context: LaunchContext, value: object, data_type: object) -> Any:
    """The value of what `normalize_typed_substitution` made.

    Raises ValueError where a text cannot be coerced, TypeError where the value is of no
    acceptable type.
    """
    if isinstance(value, ScalarTypesTuple):
        if data_type is not None and not is_instance_of(value, data_type):
            raise TypeError(f"value=`{value}` is a scalar and not an instance of `{data_type}`")
        return value
    if is_normalized_substitution(value):
        return _perform_scalar(context, value, data_type)
    if isinstance(value, list):
        return _perform_items(context, value, data_type)
    raise TypeError(f"Input value is not an acceptable 'NormalizedValueType'.Got value='{value}'")


def _perform_scalar(context: LaunchContext, value: Any, data_type: object) -> Any:
    text = perform_substitutions(context, value)
    try:
        return coerce_to_type(text, data_type)
    except ValueError as error:
        if data_type is bool:
            # Imported only for an error.
            from launcher.language.diagnostics.truth_values import add_source

            add_source(error, context, value, text)
        raise


def _perform_items(context: LaunchContext, items: list[Any], data_type: object) -> Any:
    scalar = None
    if data_type is not None:
        scalar, is_list = extract_type(data_type)
        if not is_list:
            raise ValueError(
                "The input value is a list, cannot convert it to a scalar. "
                f"Got value='{items}', expected type {scalar}."
            )
    output = [
        coerce_to_type(perform_substitutions(context, item), scalar)
        if is_normalized_substitution(item)
        else item
        for item in items
    ]
    if not is_instance_of(output, data_type):
        raise ValueError("The output list is not uniform")
    return output
