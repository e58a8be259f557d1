"""Messages of other levels than LogInfo's (newer than Jazzy)."""

from __future__ import annotations

from launcher.language.action import Action
from launcher.language.frontend_registry import parsed
from launcher.language.naming import public
from launcher.language.substitution import (
    Substitution,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext


_LEVELS = ("DEBUG", "INFO", "WARNING", "ERROR", "CRITICAL", "WARN", "FATAL")


@public("launch.actions.log")
@parsed
class Log(Action):
    """Prints a message at a level: `DEBUG`, `INFO`, `WARNING`, `ERROR`, `CRITICAL`."""

    def __init__(self, *, msg: Any, level: Any, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.__msg = normalize_to_list_of_substitutions(msg)
        if isinstance(level, str) and level.upper() not in _LEVELS:
            raise KeyError(f"Invalid log level '{level}', expected: {', '.join(_LEVELS)}")
        self.__level = normalize_to_list_of_substitutions(level)

    @property
    def msg(self) -> list[Substitution]:
        return self.__msg

    @property
    def level(self) -> list[Substitution]:
        return self.__level

    def execute(self, context: LaunchContext) -> None:
        level = perform_substitutions(context, self.level).upper()
        context._host.log("launch.user", level, perform_substitutions(context, self.msg))


@public("launch.actions.log")
class LogDebug(Log):
    """Prints a debug message."""

    def __init__(self, *, msg: Any, **kwargs: Any) -> None:
        super().__init__(msg=msg, level="DEBUG", **kwargs)


@public("launch.actions.log")
class LogWarning(Log):
    """Prints a warning."""

    def __init__(self, *, msg: Any, **kwargs: Any) -> None:
        super().__init__(msg=msg, level="WARNING", **kwargs)


@public("launch.actions.log")
class LogError(Log):
    """Prints an error."""

    def __init__(self, *, msg: Any, **kwargs: Any) -> None:
        super().__init__(msg=msg, level="ERROR", **kwargs)
