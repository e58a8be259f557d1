"""Actions on launch configurations and on the environment, and their stacks."""

from __future__ import annotations

import os
from collections.abc import Mapping

from launcher.language.action import Action
from launcher.language.frontend_registry import parsed
from launcher.language.naming import public, read_only
from launcher.language.substitution import (
    Substitution,
    normalize_to_list_of_substitutions,
    perform,
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


class _Plain(Action):
    """Base of actions that have no settings except those of every action."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)


class _Named(Action):
    """Base of actions on one name."""

    name: list[Substitution] = read_only()

    def __init__(self, name: object, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.__name = normalize_to_list_of_substitutions(name)


class _NamedValue(_Named):
    """Base of actions on a name and a value."""

    value: list[Substitution] = read_only()

    def __init__(self, name: object, value: object, **kwargs: object) -> None:
        super().__init__(name, **kwargs)
        self.__value = normalize_to_list_of_substitutions(value)


@public("launch.actions.set_launch_configuration")
@parsed
class SetLaunchConfiguration(_NamedValue):
    """Sets a launch configuration; it may not exist yet."""

    def execute(self, context: LaunchContext) -> None:
        name = perform_substitutions(context, self.name)
        value = perform_substitutions(context, self.value)
        context.launch_configurations.assign(name, value, self._origin)


@public("launch.actions.unset_launch_configuration")
@parsed
class UnsetLaunchConfiguration(_Named):
    """Removes a launch configuration, if it exists."""

    def execute(self, context: LaunchContext) -> None:
        context.launch_configurations.pop(perform_substitutions(context, self.name), None)


@public("launch.actions.reset_launch_configurations")
@parsed
class ResetLaunchConfigurations(Action):
    """Removes all launch configurations but those given, which are evaluated first."""

    _to_arguments = "resets"

    def __init__(
        self, launch_configurations: Mapping[Any, Any] | None = None, **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self.__launch_configurations = launch_configurations

    def execute(self, context: LaunchContext) -> None:
        kept = {
            perform(context, name): perform(context, value)
            for name, value in (self.__launch_configurations or {}).items()
        }
        context.launch_configurations.clear()
        context.launch_configurations.update(kept)


@public("launch.actions.push_launch_configurations")
@parsed
class PushLaunchConfigurations(_Plain):
    """Saves the launch configurations; changes last until they are popped."""

    def execute(self, context: LaunchContext) -> None:
        context._push_launch_configurations()


@public("launch.actions.pop_launch_configurations")
@parsed
class PopLaunchConfigurations(_Plain):
    """Restores the launch configurations that were pushed last."""

    def execute(self, context: LaunchContext) -> None:
        context._pop_launch_configurations()


@public("launch.actions.set_environment_variable")
@parsed
class SetEnvironmentVariable(_NamedValue):
    """Sets an environment variable for the entities after it."""

    def execute(self, context: LaunchContext) -> None:
        name = perform_substitutions(context, self.name)
        context.environment[name] = perform_substitutions(context, self.value)


@public("launch.actions.unset_environment_variable")
@parsed
class UnsetEnvironmentVariable(_Named):
    """Removes an environment variable, if it is set."""

    def execute(self, context: LaunchContext) -> None:
        context.environment.pop(perform_substitutions(context, self.name), None)


@public("launch.actions.append_environment_variable")
@parsed
class AppendEnvironmentVariable(_NamedValue):
    """Extends an environment variable at its end, or with `prepend` at its start."""

    prepend: object = read_only("Whether it goes to the start.")
    separator: list[Substitution] = read_only()

    def __init__(
        self,
        name: object,
        value: object,
        prepend: object = False,
        separator: object = os.pathsep,
        **kwargs: object,
    ) -> None:
        super().__init__(name, value, **kwargs)
        self.__prepend = normalize_typed_substitution(prepend, bool)
        self.__separator = normalize_to_list_of_substitutions(separator)

    def execute(self, context: LaunchContext) -> None:
        """Set or extend it; a variable that is set but empty keeps its separator."""
        name = perform_substitutions(context, self.name)
        value = perform_substitutions(context, self.value)
        prepend = perform_typed_substitution(context, self.prepend, bool)
        separator = perform_substitutions(context, self.separator)
        if name in context.environment:
            parts = [context.environment[name], value]
            value = separator.join(reversed(parts) if prepend else parts)
        context.environment[name] = value


@public("launch.actions.push_environment")
@parsed
class PushEnvironment(_Plain):
    """Saves the environment; changes last until it is popped."""

    def execute(self, context: LaunchContext) -> None:
        context._push_environment()


@public("launch.actions.pop_environment")
@parsed
class PopEnvironment(_Plain):
    """Restores the environment that was pushed last."""

    def execute(self, context: LaunchContext) -> None:
        context._pop_environment()


@public("launch.actions.reset_environment")
@parsed
class ResetEnvironment(_Plain):
    """Sets the environment back to that of the start of the run."""

    def execute(self, context: LaunchContext) -> None:
        context._reset_environment()


@public("launch.actions.replace_environment_variables")
@parsed
class ReplaceEnvironmentVariables(Action):
    """Replaces the whole environment."""

    environment: Mapping[Any, Any] = read_only()

    def __init__(self, environment: Mapping[Any, Any] | None = None, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.__environment = environment or {}

    def execute(self, context: LaunchContext) -> None:
        """Replace; names and values are evaluated in the old environment."""
        values = {perform(context, n): perform(context, v) for n, v in self.__environment.items()}
        context.environment.clear()
        context.environment.update(values)
