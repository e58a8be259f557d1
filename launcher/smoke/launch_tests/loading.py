"""Tests of launch_testing as they are written in a module: a run for each set of parameters."""

from __future__ import annotations

import functools
import inspect
import unittest
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from launcher.language.naming import public
from launcher.language.testing import ReadyToTest

_TIMEOUT_S = 15
_TIMEOUT_NAME = "__ready_to_test_action_timeout__"
# What gets arguments by their names, besides the test methods.
_OF_CASE = ("setUp", "tearDown")
_OF_CLASS = ("setUpClass", "tearDownClass")


@public("launch_testing.loader")
class TestRun:
    """One launch, and the tests while it runs and after it.

    `timeout`: how long ReadyToTest may take, in seconds.
    """

    __test__ = False  # for pytest

    def __init__(
        self,
        name: str,
        test_description_function: Any,
        param_args: Mapping[str, Any],
        pre_shutdown_tests: Any,
        post_shutdown_tests: Any,
    ) -> None:
        self.name = name
        self._test_description_function = test_description_function
        self.param_args = param_args
        self.pre_shutdown_tests = pre_shutdown_tests
        self.post_shutdown_tests = post_shutdown_tests
        self.timeout = getattr(test_description_function, _TIMEOUT_NAME, _TIMEOUT_S)
        self.markers: dict[str, Any] = getattr(test_description_function, "__markers__", {})
        if param_args:
            for case in self.all_cases():
                _rename(case, case._testMethodName + self._suffix())
        for suite in (*_suites(pre_shutdown_tests), *_suites(post_shutdown_tests)):
            suite._removeTestAtIndex = lambda *_: None  # the report names them afterwards

    def normalized_test_description(
        self, *, ready_fn: Callable[[], object]
    ) -> tuple[Any, Mapping[str, Any]]:
        """The description, whose ReadyToTest calls `ready_fn`, and the context of the tests."""
        result = self._test_description_function()
        description, context = result if isinstance(result, tuple) else (result, {})
        ready = next(ready_actions(description.entities), None)
        if ready is None:
            raise Exception(
                "generate_test_description functions must return a LaunchDescription containing "
                "a ReadyToTest action"
            )
        ready._add_callback(ready_fn)
        return description, context

    def bind(
        self,
        tests: Any,
        injected_attributes: Mapping[str, Any] | None = None,
        injected_args: Mapping[str, Any] | None = None,
    ) -> None:
        """Give the tests attributes, and arguments of the same names."""
        arguments = injected_args or {}
        classes: dict[Any, None] = {}
        for case in _cases(tests):
            classes[type(case)] = None
            for name in (case._testMethodName, *_OF_CASE):
                setattr(case, name, _bound(getattr(case, name), arguments))
        for one in classes:
            for name, value in (injected_attributes or {}).items():
                setattr(one, name, value)
            for name in _OF_CLASS:
                setattr(one, name, _bound(getattr(one, name), arguments))

    def get_launch_description(self) -> Any:
        """The description, to look at its arguments."""
        return self.normalized_test_description(ready_fn=lambda: None)[0]

    def all_cases(self) -> Iterator[Any]:
        yield from _cases(self.pre_shutdown_tests)
        yield from _cases(self.post_shutdown_tests)

    def __str__(self) -> str:
        return self.name + self._suffix()

    def _suffix(self) -> str:
        return f"[{', '.join(map(str, self.param_args.values()))}]" if self.param_args else ""


def LoadTestsFromPythonModule(module: Any, *, name: str = "launch_tests") -> list[TestRun]:
    """The runs of a module with `generate_test_description`."""
    function = module.generate_test_description
    descriptions: Iterable[tuple[Any, Mapping[str, Any]]] = [(function, {})]
    if hasattr(function, "__parametrized__"):
        descriptions = function()
    runs = []
    for description, arguments in descriptions:
        before, after = PreShutdownTestLoader(), PostShutdownTestLoader()
        tests = before.loadTestsFromModule(module), after.loadTestsFromModule(module)
        run = TestRun(name, description, arguments, *tests)
        # Marks may stand above `parametrize`, and so not be those of the description.
        run.timeout = getattr(function, _TIMEOUT_NAME, run.timeout)
        run.markers = {**getattr(function, "__markers__", {}), **run.markers}
        runs.append(run)
    return runs


class PhaseLoader(unittest.TestLoader):
    """Loads the test classes of one phase, each as a separate class for this run."""

    is_post_shutdown = False

    def loadTestsFromTestCase(self, testCaseClass: Any) -> Any:
        if getattr(testCaseClass, "__post_shutdown_test__", False) != self.is_post_shutdown:
            return unittest.TestSuite()
        names = {"__module__": testCaseClass.__module__, "__qualname__": testCaseClass.__qualname__}
        return super().loadTestsFromTestCase(type(testCaseClass.__name__, (testCaseClass,), names))


PreShutdownTestLoader = PhaseLoader


class PostShutdownTestLoader(PhaseLoader):
    is_post_shutdown = True


def ready_actions(entities: Iterable[Any]) -> Iterator[Any]:
    """All ReadyToTest of a description, also of entities that depend on conditions."""
    for entity in entities:
        if isinstance(entity, ReadyToTest):
            yield entity
        yield from ready_actions(entity.describe_sub_entities())
        for _, conditional in entity.describe_conditional_sub_entities():
            yield from ready_actions(conditional)


def _rename(case: Any, name: str) -> None:
    setattr(case, name, getattr(case, case._testMethodName))
    case._testMethodName = name


def _bound(function: Any, arguments: Mapping[str, Any]) -> Any:
    names = inspect.signature(function).parameters
    return functools.partial(function, **{k: v for k, v in arguments.items() if k in names})


def _cases(tests: Any) -> Iterator[Any]:
    if isinstance(tests, Iterable):
        for one in tests:
            yield from _cases(one)
    else:
        yield tests


def _suites(tests: Any) -> Iterator[Any]:
    if isinstance(tests, unittest.TestSuite):
        yield tests
        for one in tests:
            yield from _suites(one)
