"""LaunchService: runs descriptions from a script."""

from __future__ import annotations

import threading
from collections.abc import Coroutine, Iterable, Iterator
from contextlib import contextmanager

from launcher.language import launch_session
from launcher.language.context import LaunchContext
from launcher.language.events.handlers import OnIncludeLaunchDescription, OnShutdown
from launcher.language.events.launch import IncludeLaunchDescription, Shutdown
from launcher.language.host import NullHost
from launcher.language.naming import public, read_only

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Generator
    from typing import Any, NoReturn

    from launcher.language.events.base import Event

_NO_RUN = (
    "LaunchService.run() is not available inside of a launch file; start the launch file itself, "
    "or run the LaunchService in a script that says `import launcher.api` first"
)


@public("launch.launch_service")
class LaunchService:
    """Runs the descriptions that it includes; `emit_event` and `shutdown` from any thread."""

    context: LaunchContext = read_only(
        "The context, which keeps its handlers and configurations from one run to the next."
    )
    task: object = read_only("The asyncio task that awaits `run_async`; None if none does.")

    def __init__(
        self,
        *,
        argv: Iterable[str] | None = None,
        noninteractive: bool = False,
        debug: bool = False,
        log_file_name: str = "launch.log",
    ) -> None:
        self.__context = LaunchContext(argv=argv, noninteractive=noninteractive)
        self.__context.register_event_handler(OnIncludeLaunchDescription())
        self.__context.register_event_handler(OnShutdown(on_shutdown=self.__on_shutdown))
        self.__lock = threading.RLock()
        self.__is_running = False
        self.__run: launch_session.ServiceRun | None = None
        self.__task: object = None
        self.__async_thread: int | None = None
        self._stop_signal: int | None = None  # that the tests which use us pass on
        if log_file_name != "launch.log":
            launch_session.current().log_name = log_file_name.removesuffix(".log")
        if debug:
            from launcher.language.logging.config import launch_config

            launch_config.level = "DEBUG"

    @property
    def event_loop(self) -> Any:
        """The loop for coroutines of the launch; None when nothing runs."""
        return None if self.__run is None else self.__context.asyncio_loop

    def _is_idle(self) -> bool:
        """Whether nothing runs: examples of launch_pytest ask for it by this name."""
        return self.__run is None

    def emit_event(self, event: Event) -> None:
        """Queue an event; without a run it waits for the next one."""
        with self.__lock:
            if self.__run is None:
                self.__context.emit_event_sync(event)
            else:
                self.__run.post(event)

    def include_launch_description(self, launch_description: object) -> None:
        """Visit a description in this run, or at the start of the next one."""
        self.emit_event(IncludeLaunchDescription(launch_description))

    def run(self, *, shutdown_when_idle: bool = True) -> int:
        """Run until nothing is left to do, or without `shutdown_when_idle` until `shutdown`.

        0, or 1 after an exception in the launch or a SIGTERM. The end of a process, whatever its
        exit code, is no failure, as in ROS 2.
        """
        with self.__running(shutdown_when_idle) as run:
            return run.run()

    async def run_async(self, *, shutdown_when_idle: bool = True) -> int:
        """`run` within the asyncio loop of the caller, whose other tasks go on."""
        import asyncio

        with self.__running(shutdown_when_idle) as run:
            self.__task = asyncio.current_task()
            self.__context._callers_loop = asyncio.get_running_loop()
            self.__async_thread = threading.get_ident()
            try:
                return await run.run_async()
            finally:
                self.__task = self.__async_thread = None
                self.__context._callers_loop = None

    def shutdown(self, force_sync: bool = False) -> Any:
        """Stop everything; `run` returns then. Nothing if nothing runs.

        The result is a coroutine in the thread of `run_async`, also while its loop pauses, and
        wherever an asyncio loop runs; None elsewhere or with `force_sync`.
        """
        with self.__lock:
            if self.__run is not None:
                self.__run.post(Shutdown(reason="LaunchService.shutdown() called"))
        is_async = self.__async_thread == threading.get_ident() or _is_in_loop()
        return _Done() if is_async and not force_sync else None

    @contextmanager
    def __running(self, shutdown_when_idle: bool) -> Iterator[launch_session.ServiceRun]:
        runner = launch_session.current().runner
        if runner is None:
            raise RuntimeError(_NO_RUN)
        with self.__lock:
            if self.__is_running:
                raise RuntimeError("this LaunchService is already running")
            self.__is_running = True
        self.__context._set_is_shutdown(False)
        self._stop_signal = None
        try:
            run = runner(self.__context, shutdown_when_idle)
            with self.__lock:
                self.__run = run
            yield run
        finally:
            with self.__lock:
                if self.__run is not None:
                    self.__run.close()
                self.__run, self.__is_running = None, False
                self.__context._completion_futures.clear()
                self.__context._host = NullHost()

    def __on_shutdown(self, event: Event, context: LaunchContext) -> None:
        if self.__run is not None:
            self._stop_signal = self._stop_signal or self.__run.stop_signal
            self.__run.shut_down(event)


def _is_in_loop() -> bool:
    from asyncio import events

    return events._get_running_loop() is not None


class _Done(Coroutine[object, object, None]):
    """A coroutine that has nothing left to do, and may stay without an `await`."""

    def send(self, value: object) -> NoReturn:
        raise StopIteration

    def throw(self, *error: Any) -> NoReturn:
        raise error[0]

    def close(self) -> None:
        pass

    def __await__(self) -> Generator[Any, None, None]:
        yield from ()
