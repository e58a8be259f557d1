"""Fixtures of launch_pytest: a launch description that runs during the tests that use it.

Every run of pytest loads this module, so what only such tests need is imported later.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import pytest

from launcher.smoke.launch_tests.test_calls import raise_interrupt

if TYPE_CHECKING:
    import asyncio

    from launcher.language.service import LaunchService

OPTIONS = "_launch_pytest_options"
_SCOPES = ("function", "class", "module", "package", "session")


class FixtureOptions(NamedTuple):
    """How a description runs, and for which tests."""

    scope: str
    name: str
    shutdown_when_idle: bool
    auto_shutdown: bool


def fixture(
    decorated: Any = None,
    *args: Any,
    shutdown_when_idle: bool = True,
    auto_shutdown: bool = True,
    **kwargs: Any,
) -> Any:
    """A pytest fixture that returns a launch description, or a sequence that begins with one.

    `shutdown_when_idle`: the launch ends when nothing is left to do. `auto_shutdown`: it is shut
    down before the tests marked with `shutdown` and at the end. Others are for `pytest.fixture`.
    """
    scope = kwargs.get("scope", "function")
    if scope != "function":
        _widen(sys._getframe(1).f_globals, scope)

    def mark(function: Any) -> Any:
        name = kwargs.get("name") or function.__name__
        options = FixtureOptions(scope, name, shutdown_when_idle, auto_shutdown)
        setattr(function, OPTIONS, options)
        made: Any = pytest.fixture(*args, **kwargs)(function)
        setattr(made, OPTIONS, options)
        return made

    return mark if decorated is None else mark(decorated)


def _widen(names: dict[str, Any], scope: str) -> None:
    """Give a module fixtures of this scope, unless it has its own or some of a wider one."""
    for name, make in _MAKERS.items():
        known = names.get(name)
        given = getattr(known, "_launch_pytest_scope", None)
        is_narrow = given is not None and _SCOPES.index(given) < _SCOPES.index(scope)
        if known is None or is_narrow:
            names[name] = make(scope)


def finalize_launch_service(
    launch_service: Any, eprefix: str = "", auto_shutdown: bool = True
) -> None:
    """Wait for the end of a launch. AssertionError if it does not end with 0.

    KeyboardInterrupt if a Ctrl-C has ended it.
    """
    if auto_shutdown:
        launch_service.shutdown(force_sync=True)
    loop, task = launch_service.event_loop, launch_service.task
    if loop is None or task is None or loop.is_closed():
        return
    code = loop.run_until_complete(task)
    raise_interrupt(launch_service)
    if code != 0:
        raise AssertionError(
            f"{eprefix} launch service failed when finishing, return code '{code}'"
        )


def event_loop_fixture(scope: str) -> Any:
    def event_loop() -> Iterator[asyncio.AbstractEventLoop]:
        """The loop in which the launch and the coroutines of tests run."""
        import asyncio

        loop = asyncio.new_event_loop()
        asyncio.set_event_loop(loop)
        yield loop
        loop.close()
        asyncio.set_event_loop(None)

    return _scoped(event_loop, scope)


def launch_service_fixture(scope: str) -> Any:
    def launch_service(event_loop: Any) -> Iterator[LaunchService]:
        """The service that runs the description."""
        from launcher.language.service import LaunchService

        service = LaunchService()
        service.context._is_of_test = True
        yield service
        finalize_launch_service(service, "When tearing down launch_service fixture")

    return _scoped(launch_service, scope)


def launch_context_fixture(scope: str) -> Any:
    def launch_context(launch_service: Any) -> Any:
        """The context of the launch."""
        return launch_service.context

    return _scoped(launch_context, scope)


def _scoped(function: Any, scope: Any) -> Any:
    made: Any = pytest.fixture(scope=scope)(function)
    made._launch_pytest_scope = scope
    return made


_MAKERS = {
    "event_loop": event_loop_fixture,
    "launch_service": launch_service_fixture,
    "launch_context": launch_context_fixture,
}
