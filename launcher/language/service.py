"""ROS 2's API to run a description from a script; not available here."""

from __future__ import annotations

from collections.abc import Iterable

from launcher.language.context import LaunchContext
from launcher.language.naming import public

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, NoReturn


@public("launch.launch_service")
class LaunchService:
    """Collects descriptions; `run` raises RuntimeError."""

    def __init__(
        self,
        *,
        argv: Iterable[str] | None = None,
        noninteractive: bool = False,
        debug: bool = False,
    ) -> None:
        self.__context = LaunchContext(argv=argv, noninteractive=noninteractive)
        self._descriptions: list[Any] = []
        self._debug = debug

    @property
    def context(self) -> LaunchContext:
        """The context; nothing runs in it."""
        return self.__context

    @property
    def event_loop(self) -> None:
        return None

    @property
    def task(self) -> None:
        return None

    def emit_event(self, event: Any) -> None:
        self.__context.emit_event_sync(event)

    def include_launch_description(self, launch_description: Any) -> None:
        self._descriptions.append(launch_description)

    def run(self, *, shutdown_when_idle: bool = True) -> NoReturn:
        """RuntimeError: a launch file cannot run a second launcher inside this one."""
        raise RuntimeError(
            "LaunchService.run() is not available inside of a launch file; "
            "start the file with `python -m launcher FILE`"
        )

    async def run_async(self, *, shutdown_when_idle: bool = True) -> NoReturn:
        """RuntimeError, like `run`."""
        self.run(shutdown_when_idle=shutdown_when_idle)

    def shutdown(self) -> None:
        """No-op."""
