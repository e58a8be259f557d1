"""Messages of other levels than LogInfo's (newer than Jazzy)."""

from __future__ import annotations

from launcher.language.actions.events import Log
from launcher.language.naming import public

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


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
