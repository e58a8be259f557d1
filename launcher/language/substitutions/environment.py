"""EnvironmentVariable: the value of an environment variable."""

from __future__ import annotations

from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    Substitution,
    SubstitutionFailure,
    describe_substitutions,
    normalize_to_list_of_substitutions,
    optional_substitutions,
    perform_substitutions,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


@public("launch.substitutions.environment_variable")
class EnvironmentVariable(Substitution):
    """The value of an environment variable, in the scope of the visit."""

    name: list[Substitution] = read_only()
    default_value: list[Substitution] | None = read_only("Used if the variable is not set.")

    def __init__(self, name: Any, *, default_value: Any = None) -> None:
        self.__name = normalize_to_list_of_substitutions(name)
        self.__default_value = optional_substitutions(default_value)

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
