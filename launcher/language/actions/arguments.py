"""DeclareLaunchArgument: a launch argument with default and choices; a boolean one."""

from __future__ import annotations

from launcher.language.action import Action
from launcher.language.diagnostics import ros2_quirks
from launcher.language.frontend_registry import parsed
from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    Substitution,
    optional_substitutions,
    perform_substitutions,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext

_LOGGER = "launch.actions.declare_launch_argument"
_BOOLEANS = ("true", "false", "True", "False", "TRUE", "FALSE")


@public("launch.actions.declare_launch_argument")
@parsed
class DeclareLaunchArgument(Action):
    """Declares an argument; its value is the launch configuration of the same name."""

    _to_arguments = "declares"
    name: str = read_only()
    default_value: list[Substitution] | None = read_only(
        "The default; without one the argument is required."
    )
    description: str = read_only("The description with the choices.")
    choices: list[str] | None = read_only()

    def __init__(
        self,
        name: str,
        *,
        default_value: object = None,
        description: str | None = None,
        choices: list[str] | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self.__name = name
        self.__default_value = optional_substitutions(default_value)
        _check_choices(default_value, choices)
        self.__description = _describe(description, choices)
        self.__choices = choices
        # Set by the search for arguments: the declaration depends on a condition.
        self._conditionally_included = False

    def execute(self, context: LaunchContext) -> None:
        """Set the default if there is no value; RuntimeError for a missing or invalid value."""
        if self.name not in context.launch_configurations:
            if self.default_value is None:
                context._host.log(
                    _LOGGER,
                    "ERROR",
                    f'Required launch argument "{self.name}" (description: '
                    f'"{self.description}") was not provided',
                )
                raise RuntimeError(f'Required launch argument "{self.name}" was not provided.')
            value = perform_substitutions(context, self.default_value)
            context.launch_configurations.assign_default(self.name, value, self._origin)
        elif self.default_value is not None:
            ros2_quirks.value_of_another_include(context, self.name, self._origin)
        self._check_value(context)
        context._host.declared(self, context.launch_configurations[self.name])

    def _check_value(self, context: LaunchContext) -> None:
        value = context.launch_configurations[self.name]
        if self.__choices is None or value in self.__choices:
            return
        message = (
            f'Argument "{self.name}" provided value "{value}" is not valid. '
            f"Valid options are: {self.__choices}"
        )
        context._host.log(_LOGGER, "ERROR", message)
        error = RuntimeError(message)
        # Imported only for an error.
        from launcher.language.diagnostics.truth_values import add_choice

        add_choice(error, context, self.name, self.__choices)
        raise error


@public("launch.actions.declare_boolean_launch_argument")
@parsed
class DeclareBooleanLaunchArgument(DeclareLaunchArgument):
    """An argument that is true or false, in lower case, upper case or capitalized."""

    def __init__(self, name: str, *, default_value: Any = None, **kwargs: Any) -> None:
        default = str(default_value) if isinstance(default_value, bool) else default_value
        super().__init__(name, default_value=default, choices=[*_BOOLEANS], **kwargs)


def _check_choices(default_value: object, choices: list[str] | None) -> None:
    if choices is None:
        return
    if len(choices) == 0:
        raise RuntimeError("Provided choices arg is empty. Use None to ignore the choice list.")
    if default_value is None or isinstance(default_value, (Substitution, list)):
        return
    if default_value not in choices:
        raise RuntimeError(
            f'Provided default_value "{default_value}" is not in provided choices "{choices}".'
        )


def _describe(description: str | None, choices: list[str] | None) -> str:
    if description is None:
        return "no description given" if choices is None else f"One of: {choices}"
    if choices is None:
        return description
    stop = "" if description.endswith(".") else "."
    return f"{description}{stop} Valid choices are: {choices}"
