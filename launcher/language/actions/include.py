"""IncludeLaunchDescription: the entities of another launch file."""

from __future__ import annotations

import os
from collections.abc import Iterable

from launcher.language import launch_session
from launcher.language.action import Action
from launcher.language.context import LaunchContext
from launcher.language.frontend_registry import parsed
from launcher.language.naming import public, read_only
from launcher.language.sources import AnyLaunchDescriptionSource, LaunchDescriptionSource
from launcher.language.substitution import perform

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.diagnostics.origin import FileLine
    from launcher.language.entity import LaunchDescriptionEntity

# Every description has this method.
_ARGUMENTS = "get_launch_arguments_with_include_launch_description_actions"


@public("launch.actions.include_launch_description")
@parsed
class IncludeLaunchDescription(Action):
    """Yields another launch description, after setting `launch_arguments`.

    Not a scope: what the other file sets is set here afterwards. In Lyrical "this launch file" is
    again that of before.
    """

    _to_arguments = "includes"
    launch_arguments: tuple[tuple[Any, Any], ...] = read_only()

    def __init__(
        self,
        launch_description_source: object,
        *,
        launch_arguments: Iterable[tuple[Any, Any]] | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        if not isinstance(launch_description_source, LaunchDescriptionSource):
            launch_description_source = AnyLaunchDescriptionSource(launch_description_source)
        self.__launch_description_source = launch_description_source
        self.__launch_arguments = () if launch_arguments is None else tuple(launch_arguments)

    @property
    def launch_description_source(self) -> LaunchDescriptionSource:
        source: LaunchDescriptionSource = self.__launch_description_source
        return source

    def _get_launch_file(self) -> str:
        return os.path.abspath(self.launch_description_source.location)

    def _get_launch_file_directory(self) -> str:
        path = self._get_launch_file()
        if os.path.exists(path):
            return os.path.dirname(path)
        return (
            self.launch_description_source.location
        )  # like '<script>': a description that comes from no file

    def get_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """The description, if it can be loaded without a context."""
        description = self.launch_description_source.try_get_launch_description_without_context()
        return [] if description is None else [description]

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity]:
        """Load, check the arguments, yield; RuntimeError if a required one is not given."""
        description = self._load(context)
        if not hasattr(type(description), _ARGUMENTS):
            # Imported only for an error.
            from launcher.language.diagnostics.wrong_returns import no_description

            raise no_description(self, description)
        outer = self._enter_file(context)
        self._check_required(context, description)
        context._includers[self._get_launch_file()] = self._origin
        if not launch_session.current().is_like("lyrical"):
            return [*self._settings(), description]
        from launcher.language.actions.event_actions import OpaqueFunction

        leave = OpaqueFunction(function=lambda context: context.extend_locals(outer))
        return [*self._settings(), description, leave]

    def _enter_file(self, context: LaunchContext) -> dict[str, Any]:
        """Set the locals about the launch file; what they were before."""
        inner = {
            "current_launch_file_path": self._get_launch_file(),
            "current_launch_file_directory": self._get_launch_file_directory(),
        }
        known = context.get_locals_as_dict()
        context.extend_locals(inner)
        return {name: known.get(name) for name in inner}

    def _load(self, context: LaunchContext) -> Any:
        try:
            return self.launch_description_source.get_launch_description(context)
        except Exception as error:
            path = self._get_launch_file()
            is_located = self.launch_description_source._is_located
            if is_located and " object at 0x" not in path and not os.path.lexists(path):
                # Imported only for an error.
                from launcher.language.diagnostics.includes import explain_missing

                explain_missing(error, path, self._origin)
            raise

    def _settings(self) -> list[LaunchDescriptionEntity]:
        if not self.launch_arguments:
            return []
        from launcher.language.actions.configuration import SetLaunchConfiguration

        sets = [SetLaunchConfiguration(name, value) for name, value in self.launch_arguments]
        for one in sets:
            one._origin = self._origin
        return [*sets]

    def _check_required(self, context: LaunchContext, description: Any) -> None:
        # As in ROS 2, names that were given to one nested include count for all that follow.
        given = _names(context, self.launch_arguments, self._origin)
        # Those of a file that it includes are checked when that is visited, and loaded.
        try:
            pairs = description._declarations(loads=False)
        except Exception as error:
            if hasattr(error, "add_note"):  # Python 3.11; seen in a traceback, as since Kilted
                location = self.launch_description_source.location
                error.add_note(f"while executing IncludeLaunchDescription({location})")
            raise
        unknown = self._unknown(given, [argument.name for argument, _ in pairs])
        for argument, includes in pairs:
            if argument._conditionally_included or argument.default_value is not None:
                continue
            for include in includes or ():
                given += include._try_get_arguments_names_without_context()
            if argument.name not in given:
                self._warn_of_unknown(context, description, unknown)
                raise RuntimeError(
                    f"Included launch description missing required argument '{argument.name}' "
                    f"(description: '{argument.description}'), given: [{', '.join(given)}]"
                )
        if unknown:  # the files that it includes may use them, and are loaded by then
            context._host.later(lambda: self._warn_of_unknown(context, description, unknown))

    def _unknown(self, given: list[str], known: list[str]) -> list[str]:
        """The names that the file itself does not declare, although it declares some."""
        if not known or self._origin is None:
            return []
        return [name for name in dict.fromkeys(given) if name not in known]

    def _warn_of_unknown(
        self, context: LaunchContext, description: object, unknown: list[str]
    ) -> None:
        if unknown:
            # Imported only for a possible mistake.
            from launcher.language.diagnostics.includes import warn_of_unknown

            warn_of_unknown(context, self, description, unknown)

    def _try_get_arguments_names_without_context(self) -> list[str]:
        try:
            return _names(LaunchContext(), self.launch_arguments, None)
        except Exception:  # an attempt: names that need a context are unknown here
            return []


def _names(
    context: LaunchContext, arguments: Iterable[tuple[Any, Any]], origin: FileLine | None
) -> list[str]:
    if any(isinstance(one, str) or len(one) != 2 for one in arguments):
        # Imported only for an error.
        from launcher.language.diagnostics.includes import NotPairsError

        raise NotPairsError(origin)
    return [perform(context, name) for name, _ in arguments]
