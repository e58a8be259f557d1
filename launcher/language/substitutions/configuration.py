"""LaunchConfiguration, EnvironmentVariable, LocalSubstitution: values of the context."""

from __future__ import annotations

import re

from launcher.language.class_tools import ensure_argument_type, is_iterable
from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    Substitution,
    SubstitutionFailure,
    describe_substitutions,
    normalize_to_list_of_substitutions,
    optional_substitutions,
    perform_substitutions,
)
from launcher.posix.dispositions import Endable

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


@public("launch.substitutions.launch_configuration")
class LaunchConfiguration(Substitution):
    """The value of a launch configuration at the time of `perform`."""

    variable_name: list[Substitution] = read_only()
    default: list[Substitution] | None = read_only("Used if the configuration does not exist.")

    def __init__(self, variable_name: object, *, default: Any = None) -> None:
        self.__variable_name = normalize_to_list_of_substitutions(variable_name)
        self.__default: list[Substitution] | None
        if default is None:
            self.__default = None
        elif isinstance(default, str) or not is_iterable(default):
            self.__default = [_as_text(default)]
        else:
            self.__default = [_as_text(item) for item in default]

    def describe(self) -> str:
        return f"LaunchConfig({describe_substitutions(self.variable_name)})"

    def perform(self, context: LaunchContext) -> str:
        """The value, else the default; SubstitutionFailure without either."""
        name = perform_substitutions(context, self.variable_name)
        if name not in context.launch_configurations:
            if self.default is None:
                raise SubstitutionFailure(f"launch configuration '{name}' does not exist")
            return perform_substitutions(context, self.default)
        value: str = context.launch_configurations[name]
        return value


def _as_text(item: object) -> Substitution:
    # `default=5` is common.
    if isinstance(item, Substitution):
        return item
    return normalize_to_list_of_substitutions(str(item))[0]


@public("launch.substitutions.local_substitution")
class LocalSubstitution(Substitution):
    """A value of the current event: `event.returncode`, `x['key']`."""

    expression: str = read_only("Python below `context.locals.`.")

    def __init__(self, expression: str, description: str | None = None) -> None:
        ensure_argument_type(expression, str, "expression", "LocalSubstitution")
        self.__expression = expression
        self.__description = description

    def describe(self) -> str:
        text = self.__expression if self.__description is None else self.__description
        return f"LocalVar('{text}')"

    def perform(self, context: LaunchContext) -> str:
        """The value; exceptions of the expression are passed on."""
        key = re.fullmatch(_KEYED, self.expression)
        if key is not None:  # the common form, faster than eval
            value: str = getattr(context.locals, key["name"])[key["key"]]
            return value
        with Endable():
            return str(eval("context.locals." + self.expression, {"context": context}))


_KEYED = r"(?P<name>\w+)\['(?P<key>\w+)'\]"


class NamedValue(Substitution):
    """Base of substitutions of the value that a name has, or of a default."""

    name: list[Substitution] = read_only()
    default_value: list[Substitution] | None = read_only("Used if there is no such value.")

    def __init__(self, name: object, *, default_value: object = None) -> None:
        self.__name = normalize_to_list_of_substitutions(name)
        self.__default_value = optional_substitutions(default_value)


@public("launch.substitutions.environment_variable")
class EnvironmentVariable(NamedValue):
    """The value of an environment variable, in the scope of the visit."""

    def describe(self) -> str:
        """Like `EnvVar('HOME')`."""
        return f"EnvVar({describe_substitutions(self.name)})"

    def perform(self, context: LaunchContext) -> str:
        """The value, else the default; SubstitutionFailure without either."""
        name = perform_substitutions(context, self.name)
        value = context.environment.get(name)
        if value is not None:
            return value
        if self.default_value is None:
            raise SubstitutionFailure(f"environment variable '{name}' does not exist")
        return perform_substitutions(context, self.default_value)
