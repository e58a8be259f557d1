"""Waiting for a process in tests of launch_pytest: its start, output and end.

Each function has a form for coroutines, and one named `_sync` for tests in a thread. `validate` is
called with all output so far, of a process with `cached_output=True`.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

from launcher.language.actions.process import OnProcessExit, OnProcessIO, OnProcessStart

_Fact = Callable[[], Any]


async def wait_for_output(
    launch_context: Any, execute_process_action: Any, validate_output: Any, timeout: Any = None
) -> Any:
    """The last value of `validate`: the first that is true, or the one after `timeout` s."""
    fact = _fact(execute_process_action.get_stdout, validate_output)
    return await _wait(launch_context, execute_process_action, "stdout", fact, timeout)


def wait_for_output_sync(
    launch_context: Any, execute_process_action: Any, validate_output: Any, timeout: Any = None
) -> Any:
    fact = _fact(execute_process_action.get_stdout, validate_output)
    return _wait_sync(launch_context, execute_process_action, "stdout", fact, timeout)


async def assert_output(
    launch_context: Any, execute_process_action: Any, validate_output: Any, timeout: Any = None
) -> None:
    """Wait until `validate` raises no AssertionError; after `timeout` seconds it may raise one."""
    read = execute_process_action.get_stdout
    fact = _no_error(read, validate_output)
    if not await _wait(launch_context, execute_process_action, "stdout", fact, timeout):
        validate_output(read())


def assert_output_sync(
    launch_context: Any, execute_process_action: Any, validate_output: Any, timeout: Any = None
) -> None:
    read = execute_process_action.get_stdout
    fact = _no_error(read, validate_output)
    if not _wait_sync(launch_context, execute_process_action, "stdout", fact, timeout):
        validate_output(read())


async def wait_for_stderr(
    launch_context: Any, execute_process_action: Any, validate_output: Any, timeout: Any = None
) -> Any:
    fact = _fact(execute_process_action.get_stderr, validate_output)
    return await _wait(launch_context, execute_process_action, "stderr", fact, timeout)


def wait_for_stderr_sync(
    launch_context: Any, execute_process_action: Any, validate_output: Any, timeout: Any = None
) -> Any:
    fact = _fact(execute_process_action.get_stderr, validate_output)
    return _wait_sync(launch_context, execute_process_action, "stderr", fact, timeout)


async def assert_stderr(
    launch_context: Any, execute_process_action: Any, validate_output: Any, timeout: Any = None
) -> None:
    read = execute_process_action.get_stderr
    fact = _no_error(read, validate_output)
    if not await _wait(launch_context, execute_process_action, "stderr", fact, timeout):
        validate_output(read())


def assert_stderr_sync(
    launch_context: Any, execute_process_action: Any, validate_output: Any, timeout: Any = None
) -> None:
    read = execute_process_action.get_stderr
    fact = _no_error(read, validate_output)
    if not _wait_sync(launch_context, execute_process_action, "stderr", fact, timeout):
        validate_output(read())


async def wait_for_start(
    launch_context: Any, execute_process_action: Any, timeout: Any = None
) -> bool:
    """Whether it starts within `timeout` seconds, or has started before."""
    fact = _started(execute_process_action)
    return bool(await _wait(launch_context, execute_process_action, "start", fact, timeout))


def wait_for_start_sync(
    launch_context: Any, execute_process_action: Any, timeout: Any = None
) -> bool:
    fact = _started(execute_process_action)
    return bool(_wait_sync(launch_context, execute_process_action, "start", fact, timeout))


async def wait_for_exit(
    launch_context: Any, execute_process_action: Any, timeout: Any = None
) -> bool:
    """Whether it ends within `timeout` seconds, or has ended before."""
    fact = _ended(execute_process_action)
    return bool(await _wait(launch_context, execute_process_action, "exit", fact, timeout))


def wait_for_exit_sync(
    launch_context: Any, execute_process_action: Any, timeout: Any = None
) -> bool:
    fact = _ended(execute_process_action)
    return bool(_wait_sync(launch_context, execute_process_action, "exit", fact, timeout))


# ---- facts


def _fact(read: Callable[[], str], validate: Callable[[str], Any]) -> _Fact:
    return lambda: validate(read())


def _no_error(read: Callable[[], str], validate: Callable[[str], Any]) -> _Fact:
    def holds() -> bool:
        try:
            validate(read())
        except AssertionError:
            return False
        return True

    return holds


def _started(action: Any) -> _Fact:
    return lambda: "pid" in (action.process_details or {})


def _ended(action: Any) -> _Fact:
    return lambda: action.return_code is not None


# ---- waiting


async def _wait(context: Any, action: Any, kind: str, fact: _Fact, timeout: Any) -> Any:
    happened = asyncio.Event()
    with _handling(context, action, kind, happened.set):
        end = None if timeout is None else time.monotonic() + timeout
        while not (value := fact()):
            left = None if end is None else end - time.monotonic()
            if left is not None and left <= 0:
                break
            with contextlib.suppress(asyncio.TimeoutError):
                await asyncio.wait_for(happened.wait(), left)
            happened.clear()
    return value


def _wait_sync(context: Any, action: Any, kind: str, fact: _Fact, timeout: Any) -> Any:
    happened = threading.Event()
    with _handling(context, action, kind, happened.set):
        end = None if timeout is None else time.monotonic() + timeout
        while not (value := fact()):
            left = None if end is None else end - time.monotonic()
            if left is not None and left <= 0:
                break
            happened.wait(left)
            happened.clear()
    return value


@contextlib.contextmanager
def _handling(context: Any, action: Any, kind: str, happened: Callable[[], None]) -> Iterator[None]:
    handler: Any
    if kind == "start":
        handler = OnProcessStart(target_action=action, on_start=lambda *_: happened())
    elif kind == "exit":
        handler = OnProcessExit(target_action=action, on_exit=lambda *_: happened())
    elif kind == "stdout":
        handler = OnProcessIO(target_action=action, on_stdout=lambda *_: happened())
    else:
        handler = OnProcessIO(target_action=action, on_stderr=lambda *_: happened())
    context.register_event_handler(handler, append=True)
    try:
        yield
    finally:
        context.unregister_event_handler(handler)
