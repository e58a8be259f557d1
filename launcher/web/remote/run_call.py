"""A request to the control socket of a run, in a thread, so that the caller can give it up."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, TypeVar

from launcher.base.run_verb import BadCallError
from launcher.control.active_runs import NoActiveRunError
from launcher.control.client import Connection, NoRunError, RefusedError, Reply, SilentError
from launcher.posix.socket_directory import ControlError

MOST_CALLS = 32  # at the same time; others wait
_POOL = ThreadPoolExecutor(MOST_CALLS, "run-call")
NO_RUN, NO_ANSWER, UNKNOWN_RUN = "no-run", "timeout", "unknown-run"
ABSENT = (NO_RUN, UNKNOWN_RUN)

T = TypeVar("T")
FindSocket = Callable[[], Path]  # blocks for seconds if runs are silent; ControlError


async def ask(
    find: FindSocket,
    verb: str,
    names: Sequence[str],
    options: Mapping[str, Any],
    limit_s: float,
) -> Reply:
    """The reply of the run that `find` finds; BadCallError, also if there is none.

    If the task is cancelled, the connection is closed: what has not begun is not done.
    """
    call = RunCall(limit_s)
    work = asyncio.get_running_loop().run_in_executor(
        _POOL, call.carry_out, find, verb, names, options
    )
    return await _shielded(work, call)


async def first_line(find: FindSocket) -> Mapping[str, Any]:
    """What the run that `find` finds says about itself; BadCallError if there is none."""
    call = RunCall(0.0)
    work = asyncio.get_running_loop().run_in_executor(_POOL, call.introduce, find)
    return await _shielded(work, call)


async def _shielded(work: asyncio.Future[T], call: RunCall) -> T:
    try:
        return await asyncio.shield(work)
    except asyncio.CancelledError:
        call.give_up()
        work.add_done_callback(lambda done: done.cancelled() or done.exception())
        raise


class RunCall:
    """One call; `give_up`, from another thread, ends it with an error."""

    def __init__(self, limit_s: float) -> None:
        self._limit_s = limit_s
        self._lock = threading.Lock()
        self._connection: Connection | None = None
        self._is_given_up = False

    def carry_out(
        self, find: FindSocket, verb: str, names: Sequence[str], options: Mapping[str, Any]
    ) -> Reply:
        """Ask the run, and wait for its reply; BadCallError."""
        try:
            with self._connected(find) as connection:
                return connection.ask(verb, names, timeout_s=self._limit_s, **options)
        except SilentError as error:
            hint = error.hint or f"no answer to '{verb}' within {self._limit_s:g} s"
            raise BadCallError(NO_ANSWER, error.message, hint) from None
        except ControlError as error:
            raise _as_call_error(error) from None

    def introduce(self, find: FindSocket) -> Mapping[str, Any]:
        """The `run` of its first line; BadCallError."""
        try:
            with self._connected(find) as connection:
                found: Mapping[str, Any] = connection.hello["run"]
                return found
        except ControlError as error:
            raise _as_call_error(error) from None

    def give_up(self) -> None:
        """End the call: its thread gets NoRunError."""
        with self._lock:
            self._is_given_up = True
            if self._connection is not None:
                self._connection.shutdown()

    def _connected(self, find: FindSocket) -> Connection:
        connection = Connection(find())
        with self._lock:
            self._connection = connection
            if self._is_given_up:
                connection.close()
                raise NoRunError("the call was cancelled")
        return connection


def _as_call_error(error: ControlError) -> BadCallError:
    if isinstance(error, RefusedError):
        return BadCallError(error.code, error.message, error.hint)
    is_absent = isinstance(error, (NoActiveRunError, NoRunError))
    code = NO_ANSWER if isinstance(error, SilentError) else NO_RUN if is_absent else UNKNOWN_RUN
    hint = error.hint and error.hint.replace("--run ID", "the argument 'run'")
    return BadCallError(code, error.message, hint)
