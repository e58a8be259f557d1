"""Runs a LaunchService with the engine, in a script."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from launcher.base.model.events import Emitted
from launcher.base.model.run_options import RunOptions
from launcher.language.compat import vocabulary
from launcher.language.description import LaunchDescription
from launcher.language.interpreter import Interpreter
from launcher.launch.launch_core import LaunchCore, launched, supervising
from launcher.launch.target import LaunchRequest
from launcher.output.logs.run_directory import new_run_path, provide_log_root
from launcher.packages.workspace import current
from launcher.run.parts import open_node

if TYPE_CHECKING:
    import asyncio

    from launcher.language.context import LaunchContext
    from launcher.language.events.base import Event
    from launcher.language.launch_session import LaunchSession
    from launcher.posix.reactor import Reactor
    from launcher.run.supervisor import Supervisor


@contextlib.contextmanager
def script_vocabulary(
    options: RunOptions, words: Sequence[str] | None = None
) -> Iterator[LaunchSession]:
    """Like `vocabulary`, for a script: messages are printed, and a LaunchService runs."""
    provide_log_root(os.environ)
    with vocabulary(words) as session:
        session.is_script = True
        session.make_log_dir = lambda: _new_directory() if options.log_files else None
        session.open_ros_node = open_node
        session.runner = lambda context, when_idle: EngineServiceRun(
            context, session, options, shutdown_when_idle=when_idle
        )
        yield session


def _new_directory() -> str:
    path = new_run_path(os.environ)
    os.makedirs(path, exist_ok=True)
    return path


# Between the actions of a description and its first process under `run_async`: who waited for the
# actions, as launch_pytest for ReadyToTest, can register handlers for the start.
_HEAD_START_S = 0.02
# Rounds of the asyncio loop before `run_async` returns: they still see it running, however short.
_LAST_ROUNDS = 5


class EngineServiceRun:
    """One run of a LaunchService, which owns the context and calls `close` at the end."""

    def __init__(
        self,
        context: LaunchContext,
        session: LaunchSession,
        options: RunOptions,
        *,
        shutdown_when_idle: bool,
    ) -> None:
        self._context = context
        self._session = session
        self._options = options
        self._shutdown_when_idle = shutdown_when_idle
        self._posted: deque[Any] = deque()
        self._wake = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._supervisor: Supervisor | None = None
        self._request = LaunchRequest(path=os.path.abspath(sys.argv[0] or "<script>"))
        self._interpreter = Interpreter(
            LaunchDescription(), path=self._request.path, context=context, stays=self._stays
        )
        self._core = LaunchCore(
            self._interpreter, LaunchDescription(), self._request, adapt=options.with_prefix
        )

    # ---- the side of the service

    @property
    def stop_signal(self) -> int | None:
        return None if self._supervisor is None else self._supervisor.stop_signal

    def post(self, event: Event) -> None:
        """Queue an event, from any thread."""
        self._posted.append(event)
        os.eventfd_write(self._wake, 1)

    def shut_down(self, event: Event) -> None:
        """All handlers of this Shutdown have been called."""
        self._interpreter.decide_shutdown(event)

    def run(self) -> int:
        """Run to the end; 0 or 1."""
        with self._running() as (supervisor, reactor), supervisor.running():
            reactor.run()
        return self._code(supervisor)

    async def run_async(self) -> int:
        """The same within the running asyncio loop; a cancellation stops everything first."""
        import asyncio

        with self._running() as (supervisor, reactor):
            await asyncio.sleep(_HEAD_START_S)
            with supervisor.running():
                finished = await _serve(reactor, self._cancelled)
        return self._code(supervisor) if finished else 1

    def close(self) -> None:
        """Release the descriptor; idempotent."""
        if self._wake >= 0:
            os.close(self._wake)
            self._wake = -1

    # ---- the run

    @contextlib.contextmanager
    def _running(self) -> Iterator[tuple[Supervisor, Reactor]]:
        sys.stdout.flush()  # what the script has printed comes first
        session, path = self._session, None
        if self._options.log_files:
            path = session.log_dir
        try:
            self._core.effects = self._interpreter.resume()
            script = launched(
                self._request,
                path=path,
                session=session,
                is_script=True,
                is_test=self._context._is_of_test,
            )
            with supervising(self._core, self._options, script) as (supervisor, reactor):
                self._supervisor = supervisor
                supervisor.stay_while(self._stays)
                reactor.add_reader(self._wake, lambda: self._deliver(supervisor))
                yield supervisor, reactor
        finally:
            self._interpreter.close()
            session.forget_log_dir()
        if self._interpreter.failure is not None:
            print(self._interpreter.failure.render(), file=sys.stderr)

    def _stays(self) -> bool:
        if self._context.is_shutdown:
            return False
        return not self._shutdown_when_idle or bool(self._posted)

    def _deliver(self, supervisor: Supervisor) -> None:
        os.eventfd_read(self._wake)
        while self._posted:
            supervisor.feed(Emitted(self._posted.popleft()))

    def _cancelled(self) -> None:
        from launcher.language.events.launch import Shutdown

        self.post(Shutdown(reason="the task of LaunchService.run_async() was cancelled"))

    def _code(self, supervisor: Supervisor) -> int:
        is_terminated = supervisor.stop_signal not in (None, signal.SIGINT)
        return int(is_terminated or self._interpreter.failure is not None)


async def _serve(reactor: Reactor, on_cancel: Callable[[], None]) -> bool:
    """Run the reactor inside of the asyncio loop; False if it was cancelled meanwhile."""
    import asyncio

    loop = asyncio.get_running_loop()
    turns = _Turns(reactor, loop)
    was_cancelled = False
    try:
        turns.turn()
        while True:
            try:
                await asyncio.shield(turns.finished)
                for _ in range(_LAST_ROUNDS):
                    await asyncio.sleep(0)
                return not was_cancelled
            except asyncio.CancelledError:
                if was_cancelled:
                    raise
                was_cancelled = True
                on_cancel()
    finally:
        turns.close()


class _Turns:
    """Turns a reactor whenever it has something to do."""

    def __init__(self, reactor: Reactor, loop: asyncio.AbstractEventLoop) -> None:
        self._reactor = reactor
        self._loop = loop
        self._timer: asyncio.TimerHandle | None = None
        self._fd = reactor.fileno()
        self.finished: asyncio.Future[None] = loop.create_future()
        loop.add_reader(self._fd, self.turn)

    def turn(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if self.finished.done():
            return
        try:
            goes_on = self._reactor.turn()
        except Exception as error:
            self.finished.set_exception(error)
            return
        if not goes_on:
            self.finished.set_result(None)
            return
        delay_s = self._reactor.timeout_s()
        if delay_s is not None:
            self._timer = self._loop.call_later(delay_s, self.turn)

    def close(self) -> None:
        self._loop.remove_reader(self._fd)
        if self._timer is not None:
            self._timer.cancel()


def run_script(request: LaunchRequest, options: RunOptions) -> int:
    """Run a Python file as the program that it is; its exit code."""
    import runpy

    load_libraries()
    words = [request.path, *(f"{name}:={value}" for name, value in request.arguments)]
    with script_vocabulary(options) as session:
        session.is_debug, session.log_name = request.debug, request.log_name
        sys.argv = words
        try:
            runpy.run_path(request.path, run_name="__main__")
        except SystemExit as ended:
            return _exit_code(ended.code)
    return 0


def load_libraries() -> None:
    """Those of the workspace, for a script or test that may import rclpy and types."""
    workspace = current()
    if workspace is not None:
        from launcher.packages import activation

        activation.load_libraries(workspace)


def _exit_code(code: Any) -> int:
    if code is None or isinstance(code, int):
        return int(code or 0)
    print(code, file=sys.stderr)
    return 1
