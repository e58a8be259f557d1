"""OpaqueCoroutine: runs a coroutine of the launch file concurrently with the launch."""

from __future__ import annotations

import inspect
from collections.abc import Awaitable, Callable, Iterable

from launcher.language.action import Action
from launcher.language.class_tools import ensure_argument_type
from launcher.language.events.handlers import OnShutdown
from launcher.language.naming import public

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.context import LaunchContext
    from launcher.language.events.base import Event


@public("launch.actions.opaque_coroutine")
class OpaqueCoroutine(Action):
    """Runs a coroutine function with the context (unless `ignore_context`) and arguments."""

    def __init__(
        self,
        *,
        coroutine: Callable[..., Awaitable[None]],
        args: Iterable[Any] | None = None,
        kwargs: dict[str, Any] | None = None,
        ignore_context: bool = False,
        **left_over_kwargs: Any,
    ) -> None:
        super().__init__(**left_over_kwargs)
        if not inspect.iscoroutinefunction(coroutine):
            raise TypeError(
                "OpaqueCoroutine expected a coroutine function for 'coroutine', "
                f"got '{type(coroutine)}'"
            )
        ensure_argument_type(args, (Iterable, type(None)), "args", "OpaqueCoroutine")
        ensure_argument_type(kwargs, (dict, type(None)), "kwargs", "OpaqueCoroutine")
        ensure_argument_type(ignore_context, bool, "ignore_context", "OpaqueCoroutine")
        self.__coroutine = coroutine
        self.__args: list[Any] = [] if args is None else list(args)
        self.__kwargs: dict[str, Any] = {} if kwargs is None else kwargs
        self.__ignore_context = ignore_context
        self.__future: Any = None

    def execute(self, context: LaunchContext) -> None:
        given = [] if self.__ignore_context else [context]
        coroutine = self.__coroutine(*given, *self.__args, **self.__kwargs)
        self.__future = context._host.asyncio_loop().create_task(coroutine)
        context.add_completion_future(self.__future)
        context.register_event_handler(OnShutdown(on_shutdown=self.__on_shutdown))

    def __on_shutdown(self, event: Event, context: LaunchContext) -> None:
        if self.__future is not None:
            self.__future.cancel()

    def get_asyncio_future(self) -> Any:
        return self.__future
