"""Normalises the parameters of launch files, and evaluates them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from launcher.language.class_tools import ensure_argument_type
from launcher.language.ros.parameter_descriptions import Parameter, ParameterFile, ParameterValue
from launcher.language.substitution import (
    SomeSubstitutionsType_types_tuple,
    Substitution,
    TextSubstitution,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext

_SCALARS = (bool, int, float, str)


# ---- normalising, without a context


def normalize_parameters(parameters: object) -> tuple[Any, ...]:
    """Dictionaries with names as tuples of substitutions, files as ParameterFile."""
    if isinstance(parameters, str) or not isinstance(parameters, Sequence):
        raise TypeError(f"Expecting list of parameters, got {parameters}")
    return tuple(_normalize_parameter(parameter) for parameter in parameters)


def _normalize_parameter(parameter: object) -> Any:
    if isinstance(parameter, Mapping):
        return normalize_parameter_dict(parameter)
    if isinstance(parameter, (Parameter, ParameterFile)):
        return parameter
    if isinstance(parameter, Path):
        parameter = str(parameter)
    ensure_argument_type(parameter, SomeSubstitutionsType_types_tuple, "parameters")
    return ParameterFile(param_file=parameter)


def normalize_parameter_dict(
    parameters: object, *, _prefix: Sequence[Substitution] | None = None
) -> dict[tuple[Substitution, ...], Any]:
    """One flat dictionary; names of nested ones are joined with dots."""
    if not isinstance(parameters, Mapping):
        raise TypeError("expected dict")
    normalized: dict[tuple[Substitution, ...], Any] = {}
    for given_name, value in parameters.items():
        name = normalize_to_list_of_substitutions(given_name)
        if _prefix:
            name = [*_prefix, TextSubstitution(text="."), *name]
        if isinstance(value, Mapping):
            normalized.update(normalize_parameter_dict(value, _prefix=name))
        else:
            normalized[tuple(name)] = _normalize_value(value)
    return normalized


def _normalize_value(value: object) -> Any:
    if isinstance(value, str):
        return tuple(normalize_to_list_of_substitutions(_texts().value_text(value)))
    if isinstance(value, Substitution):
        return tuple(normalize_to_list_of_substitutions(value))
    if isinstance(value, (float, bool, int, bytes, ParameterValue)):
        return value
    if isinstance(value, Sequence):
        return _normalize_array(value)
    raise TypeError(f"Unexpected type for parameter value {value!r}")


def _normalize_array(value: Sequence[Any]) -> tuple[Any, ...]:
    kinds = {_kind_of_item(item) for item in value}
    if kinds == {int}:
        return tuple(int(item) for item in value)
    if kinds in ({float}, {int, float}):
        return tuple(float(item) for item in value)
    if Substitution in kinds and kinds <= {str, Substitution}:
        # ROS 2 reads texts and substitutions side by side as one text, not as a list.
        return tuple(normalize_to_list_of_substitutions(value))
    if kinds == {bool}:
        return tuple(bool(item) for item in value)
    return tuple(
        normalize_to_list_of_substitutions(
            _texts().value_text(item) if isinstance(item, _SCALARS) else item
        )
        for item in value
    )


def _kind_of_item(item: object) -> type:
    ensure_argument_type(item, _SCALARS + SomeSubstitutionsType_types_tuple, "subvalue")
    for kind in (Substitution, str, bool, int, float):
        if isinstance(item, kind):
            return kind
    if isinstance(item, Sequence):
        return tuple
    raise RuntimeError(f"Failed to handle type {item!r}")


# ---- evaluating: with a context


def evaluate_parameters(context: LaunchContext, parameters: Any) -> tuple[Any, ...]:
    """Normalised parameters as paths, dictionaries of values, and Parameter objects."""
    output: list[Any] = []
    for parameter in parameters:
        if isinstance(parameter, ParameterFile):
            output.append(parameter.evaluate(context))
        elif isinstance(parameter, Parameter):
            output.append(parameter)
        elif isinstance(parameter, Mapping):
            output.append(evaluate_parameter_dict(context, parameter))
    return tuple(output)


def evaluate_parameter_dict(context: LaunchContext, parameters: object) -> dict[str, Any]:
    """Names and values of a normalised dictionary; lists become tuples."""
    if not isinstance(parameters, Mapping):
        raise TypeError("expected dict")
    output: dict[str, Any] = {}
    for name, value in parameters.items():
        if not isinstance(name, tuple):
            raise TypeError(f"Expecting tuple of substitutions got {name!r}")
        evaluated_name = perform_substitutions(context, list(name))
        evaluated = _evaluate_value(context, evaluated_name, value)
        if evaluated is None:
            raise TypeError(f"given unnormalized parameters {name!r}, {value!r}")
        output[evaluated_name] = evaluated
    return output


def _evaluate_value(context: LaunchContext, name: str, value: object) -> Any:
    if isinstance(value, ParameterValue):
        return value.evaluate(context)
    if not isinstance(value, tuple) or not value:
        ensure_argument_type(value, (float, int, str, bool, bytes), "value")
        return value
    if isinstance(value[0], Substitution):
        return _from_yaml(name, perform_substitutions(context, list(value)))
    if isinstance(value[0], Sequence):
        items = [_texts().value_of(perform_substitutions(context, list(v))) for v in value]
        return _uniform(name, items)
    return tuple(type(value[0])(item) for item in value)


def _from_yaml(name: str, text: str) -> Any:
    import yaml

    advice = (
        "If the parameter is meant to be a string, try wrapping it in "
        "launch_ros.parameter_descriptions.ParameterValue(value, value_type=str)"
    )
    try:
        value = _texts().value_of(text or "''")
    except yaml.YAMLError:
        raise TypeError(
            f"Unable to parse the value of parameter {name} as yaml. {advice}"
        ) from None
    if isinstance(value, (bool, int, float, str, bytes)):
        return value
    if isinstance(value, Sequence):
        return _uniform(name, value)
    raise TypeError(
        "Allowed value types are bytes, bool, int, float, str, Sequence[bool], Sequence[int], "
        f'Sequence[float], Sequence[str]. Got {type(value).__name__} for "{name}". {advice}'
    )


def _uniform(name: str, items: Sequence[Any]) -> tuple[Any, ...]:
    kind = next((one for one in _SCALARS if items and isinstance(items[0], one)), None)
    if kind is None or not all(isinstance(item, kind) for item in items):
        raise TypeError(
            "Expected a non-empty sequence, with items of uniform type. "
            "Allowed sequence item types are bool, int, float, str. "
            f'Got inconsistent input for "{name}"'
        )
    if kind is str and len({type(item) for item in items}) > 1:
        return tuple(map(str, items))  # not one ExponentText among others
    return tuple(items)


def _texts() -> Any:
    from launcher.base.model import parameter_text  # only for launch files with parameters

    return parameter_text
