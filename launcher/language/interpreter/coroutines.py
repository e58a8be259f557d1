"""An asyncio loop for coroutines of launch files, driven by the run's own timers."""

from __future__ import annotations

import asyncio
import contextvars
from asyncio import events
from collections.abc import Callable

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.language.host import EntityHost


class TimerLoop(asyncio.AbstractEventLoop):
    """Tasks, futures and sleeping; no sockets, no subprocesses.

    Ready callbacks run as deferred steps of the interpreter, so that coroutines and events
    interleave in a fixed order, in real and in virtual time.
    """

    def __init__(self, host: EntityHost) -> None:
        self._host = host
        self._tasks: set[asyncio.Task[Any]] = set()
        self._timer_ids: dict[int, int] = {}
        self._closed = False

    def call_soon(  # type: ignore[override]
        self, callback: Callable[..., Any], *args: Any, context: contextvars.Context | None = None
    ) -> asyncio.Handle:
        handle = asyncio.Handle(callback, args, self, context)
        self._host.later(lambda: self._run(handle))
        return handle

    call_soon_threadsafe = call_soon  # type: ignore[assignment]

    def call_later(  # type: ignore[override]
        self,
        delay: float,
        callback: Callable[..., Any],
        *args: Any,
        context: contextvars.Context | None = None,
    ) -> asyncio.TimerHandle:
        handle = asyncio.TimerHandle(delay, callback, args, self, context)
        timer_id = self._host.call_later(max(0.0, delay), lambda: self._run(handle))
        setattr(handle, "_scheduled", True)  # noqa: B010 - cancelled handles then call _timer_handle_cancelled
        self._timer_ids[id(handle)] = timer_id
        return handle

    def call_at(  # type: ignore[override]
        self,
        when: float,
        callback: Callable[..., Any],
        *args: Any,
        context: contextvars.Context | None = None,
    ) -> asyncio.TimerHandle:
        return self.call_later(when, callback, *args, context=context)

    def _timer_handle_cancelled(self, handle: asyncio.TimerHandle) -> None:
        timer_id = self._timer_ids.pop(id(handle), None)
        if timer_id is not None:
            self._host.cancel_call(timer_id)

    def _run(self, handle: asyncio.Handle) -> None:
        self._timer_ids.pop(id(handle), None)
        if handle.cancelled() or self._closed:
            return
        outer = events._get_running_loop()
        events._set_running_loop(self)
        try:
            handle._run()
        finally:
            events._set_running_loop(outer)

    def time(self) -> float:
        """Zero: times are relative here, see `call_at`."""
        return 0.0

    def create_future(self) -> asyncio.Future[Any]:
        return asyncio.Future(loop=self)

    def create_task(self, coro: Any, **kwargs: Any) -> asyncio.Task[Any]:
        task: asyncio.Task[Any] = asyncio.Task(coro, loop=self, **kwargs)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    def run_in_executor(self, executor: Any, func: Any, *args: Any) -> asyncio.Future[Any]:  # type: ignore[override]
        """Call the function in the next iteration of the loop, without a thread."""
        future = self.create_future()

        def call() -> None:
            try:
                future.set_result(func(*args))
            except Exception as error:
                future.set_exception(error)

        self.call_soon(call)
        return future

    def get_debug(self) -> bool:
        return False

    def is_running(self) -> bool:
        return not self._closed

    def is_closed(self) -> bool:
        return self._closed

    def default_exception_handler(self, context: dict[str, Any]) -> None:
        self.call_exception_handler(context)

    def call_exception_handler(self, context: dict[str, Any]) -> None:
        """Log the error; a failed coroutine does not end the run, as in ROS 2."""
        text = f"{context.get('message')}: {context.get('exception', '')}"
        self._host.log("launch", "ERROR", text)

    def shut_down(self) -> None:
        """Close the coroutines that are still waiting."""
        self._closed = True
        for task in tuple(self._tasks):
            coroutine: Any = task.get_coro()
            task._log_destroy_pending = False  # type: ignore[attr-defined]
            coroutine.close()
        self._tasks.clear()


def make_loop(host: EntityHost) -> TimerLoop:
    """A loop for the coroutines of one run; unsupported methods raise NotImplementedError."""
    loop_class: Any = TimerLoop
    loop_class.__abstractmethods__ = frozenset()
    loop: TimerLoop = loop_class(host)
    return loop
