"""ParameterValue, Parameter and ParameterFile: parameters with a type, or from a file."""

from __future__ import annotations

import os
from pathlib import Path

from launcher.base import text_file
from launcher.language import frontend_registry
from launcher.language.class_tools import ensure_argument_type
from launcher.language.naming import public, read_only
from launcher.language.ros.generated_files import write_parameter_file
from launcher.language.substitution import (
    SomeSubstitutionsType_types_tuple,
    Substitution,
    SubstitutionFailure,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from launcher.language.type_utils import (
    normalize_typed_substitution,
    perform_typed_substitution,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


def _type_name(value_type: Any) -> str:
    return getattr(value_type, "__name__", str(value_type))


@public("launch_ros.parameter_descriptions")
class ParameterValue:
    """A value, or substitutions that are coerced to `value_type` (by YAML's rules for None)."""

    value_type: Any = read_only()

    def __init__(self, value: Any, *, value_type: Any = None) -> None:
        self.__value = normalize_typed_substitution(value, value_type)
        self.__value_type = value_type
        self.__evaluated: Any = None

    @property
    def value(self) -> Any:
        """The value as given; after `evaluate` the result."""
        return self.__value if self.__evaluated is None else self.__evaluated

    def __str__(self) -> str:
        return (
            "launch_ros.description.ParameterValue"
            f"(value={self.value}, value_type={_type_name(self.value_type)})"
        )

    def evaluate(self, context: LaunchContext) -> Any:
        """The value in this context."""
        self.__evaluated = perform_typed_substitution(context, self.value, self.value_type)
        return self.__evaluated


@public("launch_ros.parameter_descriptions")
class Parameter:
    """A parameter that goes to the node as `-p name:=value`."""

    def __init__(self, name: Any, value: Any, *, value_type: Any = None) -> None:
        ensure_argument_type(name, SomeSubstitutionsType_types_tuple, "name")
        self.__name = normalize_to_list_of_substitutions(name)
        self.__parameter_value = ParameterValue(value, value_type=value_type)
        self.__evaluated_name: str | None = None
        self.__evaluated_rule: tuple[str, Any] | None = None

    @property
    def name(self) -> Any:
        """The name; once evaluated, as a text."""
        return self.__name if self.__evaluated_name is None else self.__evaluated_name

    @property
    def value(self) -> Any:
        return self.__parameter_value.value

    @property
    def value_type(self) -> Any:
        return self.__parameter_value.value_type

    def __str__(self) -> str:
        return (
            "launch_ros.description.Parameter"
            f"(name={self.name}, value={self.value}, value_type={_type_name(self.value_type)})"
        )

    def evaluate(self, context: LaunchContext) -> tuple[str, Any]:
        """(name, value) in this context; evaluated once."""
        if self.__evaluated_rule is None:
            name = perform_substitutions(context, self.name)
            value = self.__parameter_value.evaluate(context)
            self.__evaluated_name = name
            self.__evaluated_rule = (name, value)
        return self.__evaluated_rule


@public("launch_ros.parameter_descriptions")
class ParameterFile:
    """A parameter file; with `allow_substs`, substitutions in it are performed into a copy."""

    def __init__(self, param_file: Any, *, allow_substs: Any = False) -> None:
        ensure_argument_type(
            param_file,
            (*SomeSubstitutionsType_types_tuple, os.PathLike, bytes),
            "param_file",
            "ParameterFile()",
        )
        ensure_argument_type(allow_substs, bool, "allow_subst", "ParameterFile()")
        self.__param_file: Any = param_file
        if isinstance(param_file, SomeSubstitutionsType_types_tuple):
            self.__param_file = normalize_to_list_of_substitutions(param_file)
        self.__allow_substs = normalize_typed_substitution(allow_substs, bool)
        self.__evaluated_param_file: Path | None = None
        self.__created_tmp_file = False

    @property
    def param_file(self) -> Any:
        """The file as given; after `evaluate` the path."""
        if self.__evaluated_param_file is not None:
            return self.__evaluated_param_file
        return self.__param_file

    @property
    def allow_substs(self) -> bool | list[Substitution]:
        """Whether substitutions in the file are performed."""
        allowed: bool | list[Substitution] = self.__allow_substs
        return allowed

    def __str__(self) -> str:
        return (
            "launch_ros.description.ParameterFile"
            f"(param_file={self.param_file}, allow_substs={self.allow_substs})"
        )

    def evaluate(self, context: LaunchContext) -> Path:
        """The path in this context; evaluated once."""
        if self.__evaluated_param_file is None:
            path = self.__param_file
            if isinstance(path, list):
                path = perform_substitutions(context, path)
            path = Path(os.fsdecode(path))
            if perform_typed_substitution(context, self.__allow_substs, bool):
                path = self._substituted(context, path)
            self.__evaluated_param_file = path
        return self.__evaluated_param_file

    def _substituted(self, context: LaunchContext, path: Path) -> Path:
        from launcher.base.model import parameter_text

        substitutions = frontend_registry.parse_substitution(text_file.read(path))
        text = perform_substitutions(context, substitutions)
        try:
            content = parameter_text.read(text)
        except Exception:
            raise SubstitutionFailure(
                "The substituted parameter file is not a valid yaml file"
            ) from None
        self.__created_tmp_file = True
        return Path(write_parameter_file(context, text, content, str(path)))

    def cleanup(self) -> None:
        """Delete the copy, if one was made."""
        if self.__created_tmp_file and self.__evaluated_param_file is not None:
            self.__evaluated_param_file.unlink(missing_ok=True)
            self.__evaluated_param_file = None
