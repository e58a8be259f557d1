"""The part of the pytest plugin for launch_pytest: collects and runs what `mark.launch` marks.

Every run of pytest loads this module, so what only such tests need is imported later.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Generator, Sequence
from typing import TYPE_CHECKING, Any

import pytest

from launcher.smoke.launch_tests.launch_fixtures import (
    OPTIONS,
    FixtureOptions,
    event_loop_fixture,
    finalize_launch_service,
    launch_context_fixture,
    launch_service_fixture,
)
from launcher.smoke.launch_tests.test_calls import complete, in_thread, raise_interrupt

if TYPE_CHECKING:
    import asyncio

    from launcher.language.description import LaunchDescription

event_loop = event_loop_fixture("function")
launch_service = launch_service_fixture("function")
launch_context = launch_context_fixture("function")

_NO_FIXTURE = '"fixture" keyword argument is required in a pytest.mark.launch() decorator'
_NO_LAUNCH_FIXTURE = (
    "{} is no launch_pytest fixture: decorate it with @launch_pytest.fixture instead of "
    "@pytest.fixture, and pass the function itself to pytest.mark.launch(fixture=...)"
)
_TOO_LONG = "launch tests using {} must stop iteration after yielding once"
_NOT_BOTH = (
    "generator or async generator based launch test items cannot be marked with shutdown=True"
)


class LaunchTestWarning(pytest.PytestWarning):
    """A test is marked incompletely."""


class _Launch:
    """What an item has besides others: `is_shutdown`, and the `partner` that it goes on with."""

    def __init__(self, options: FixtureOptions, key: object, *, is_shutdown: bool) -> None:
        self.options = options
        self.key = key  # of the launches that are shared
        self.is_shutdown = is_shutdown
        self.partner: _Launch | None = None
        self.generator: Any = None


_LAUNCH = pytest.StashKey[_Launch]()
_FAULT = pytest.StashKey[str]()  # why an item fails without a run


# ---- the fixture


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_fixture_setup(
    fixturedef: Any, request: pytest.FixtureRequest
) -> Generator[None, object, object]:
    """Run the description that a fixture returns."""
    options: FixtureOptions | None = getattr(fixturedef.func, OPTIONS, None)
    if options is None:
        return (yield)
    import asyncio

    from launcher.language.description import LaunchDescription

    service = request.getfixturevalue("launch_service")
    loop = request.getfixturevalue("event_loop")
    value = yield
    prefix = f"When running launch_pytest fixture '{options.name}':"
    description = value[0] if isinstance(value, Sequence) and value else value
    if not isinstance(description, LaunchDescription):
        raise AssertionError(
            f"{prefix} return value must be either a launch description or a sequence which first "
            "item is a launch description"
        )
    ready = asyncio.Event()
    _ready_action(description)._add_callback(ready.set)
    service.include_launch_description(description)
    task = loop.create_task(service.run_async(shutdown_when_idle=options.shutdown_when_idle))
    fixturedef.addfinalizer(
        functools.partial(finalize_launch_service, service, prefix, options.auto_shutdown)
    )
    loop.run_until_complete(_until(ready, task))
    raise_interrupt(service)
    if not ready.is_set():
        raise AssertionError(f"{prefix} the launch ended before ReadyToTest")
    return value


async def _until(ready: asyncio.Event, task: asyncio.Task[Any]) -> None:
    import asyncio

    waiting = asyncio.ensure_future(ready.wait())
    await asyncio.wait({waiting, task}, return_when=asyncio.FIRST_COMPLETED)
    waiting.cancel()


def _ready_action(description: LaunchDescription) -> Any:
    from launcher.language.testing import ReadyToTest
    from launcher.smoke.launch_tests.loading import ready_actions

    found = list(ready_actions(description.entities))
    if len(found) > 1:
        raise RuntimeError(
            "launch_pytest fixtures must return a LaunchDescription containing only one "
            "ReadyToTest action"
        )
    if not found:
        found.append(ReadyToTest())
        description.entities.append(found[0])
    return found[0]


# ---- collection


@pytest.hookimpl(tryfirst=True)
def pytest_pycollect_makeitem(collector: Any, name: str, obj: Any) -> Any:
    """The items of a marked function: a generator for several tests has another one at the end."""
    if not inspect.isfunction(obj) or not collector.funcnamefilter(name):
        return None
    marks = [one for one in getattr(obj, "pytestmark", []) if one.name == "launch"]
    mark = marks[-1] if marks else collector.get_closest_marker("launch")
    if mark is None:
        return None
    made = mark.kwargs.get("fixture")
    if made is None:
        item = pytest.Function.from_parent(collector, name=name)
        item.warn(LaunchTestWarning(_NO_FIXTURE))
        item.add_marker(pytest.mark.skip(_NO_FIXTURE))
        return [item]
    options: FixtureOptions | None = getattr(made, OPTIONS, None)
    if options is None:
        return _refused(collector, name, obj, made)
    pytest.mark.usefixtures(options.name, "launch_service", "event_loop")(obj)
    items = _items(collector, name, obj, options, made, bool(mark.kwargs.get("shutdown")))
    if options.scope != "function" and _is_generator(obj):
        last = _items(collector, name, obj, options, made, True)
        for item, other in zip(items, last, strict=True):
            other.name += "[shutdown_test]"
            other.stash[_LAUNCH].partner = item.stash[_LAUNCH]
        items += last
    return items


def _refused(collector: Any, name: str, obj: Any, made: object) -> list[Any]:
    """Items that fail, since their mark names something else than a fixture with a launch."""
    items = list(collector._genfunctions(name, obj))
    for item in items:
        item.stash[_FAULT] = _NO_LAUNCH_FIXTURE.format(getattr(made, "__name__", repr(made)))
    return items


def _items(
    collector: Any, name: str, obj: Any, options: FixtureOptions, made: Any, is_shutdown: bool
) -> list[Any]:
    items = list(collector._genfunctions(name, obj))
    for item in items:
        parameters = getattr(getattr(item, "callspec", None), "params", {})
        key = None
        if options.scope != "function":
            key = (id(made), repr(parameters.get(options.name)))
        item.stash[_LAUNCH] = _Launch(options, key, is_shutdown=is_shutdown)
    return items


def _is_generator(function: object) -> bool:
    return inspect.isgeneratorfunction(function) or inspect.isasyncgenfunction(function)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[Any]) -> None:
    """Of the tests that share a launch, those after its shutdown come last."""
    last: dict[object, Any] = {}
    shutdowns: dict[object, list[Any]] = {}
    for item in items:
        launch = item.stash.get(_LAUNCH, None)
        if launch is None or launch.key is None:
            continue
        if launch.is_shutdown:
            shutdowns.setdefault(launch.key, []).append(item)
        else:
            last[launch.key] = item
    moved = {id(item) for key in last for item in shutdowns.get(key, ())}
    followers = {id(item): shutdowns.get(key, []) for key, item in last.items()}
    items[:] = [
        one
        for item in items
        if id(item) not in moved
        for one in (item, *followers.get(id(item), ()))
    ]


# ---- execution


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: Any) -> bool | None:
    """Run a test while the loop of its launch runs: a plain function in another thread."""
    if _FAULT in pyfuncitem.stash:
        pytest.fail(pyfuncitem.stash[_FAULT], pytrace=False)
    launch = pyfuncitem.stash.get(_LAUNCH, None)
    if launch is None:
        return None
    _call(launch, pyfuncitem)
    return True


def _call(launch: _Launch, item: Any) -> None:
    function, loop = item.obj, item.funcargs["event_loop"]
    service = item.funcargs["launch_service"]
    end = functools.partial(
        finalize_launch_service,
        service,
        f"When running test {item.name}",
        launch.options.auto_shutdown,
    )
    if launch.partner is not None:
        if launch.partner.generator is None:
            pytest.skip("shutdown test skipped because the test failed before")
        end()
        _finish(launch.partner.generator, loop)
        return
    if launch.is_shutdown:
        if _is_generator(function):
            pytest.fail(_NOT_BOTH)
        end()
    names = item._fixtureinfo.argnames
    call = functools.partial(function, **{name: item.funcargs[name] for name in names})
    if not _is_generator(function):
        is_coroutine = inspect.iscoroutinefunction(function)
        complete(loop, service, call() if is_coroutine else in_thread(call))
        return
    generator = call()
    if inspect.isasyncgen(generator):
        complete(loop, service, generator.__anext__())
    else:
        complete(loop, service, in_thread(functools.partial(next, generator, None)))
    launch.generator = generator
    if launch.options.scope == "function":
        end()
        _finish(generator, loop)


def _finish(generator: Any, loop: Any) -> None:
    """The part of a test behind its `yield`."""
    kind = "an async gen function" if inspect.isasyncgen(generator) else "a generator function"
    try:
        if inspect.isasyncgen(generator):
            loop.run_until_complete(generator.__anext__())
        else:
            next(generator)
    except (StopIteration, StopAsyncIteration):
        return
    pytest.fail(_TOO_LONG.format(kind), pytrace=False)
