"""Tests of launch_testing as pytest collects them: one item for a file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
from _pytest.pathlib import import_path

from launcher.smoke.launch_tests.loading import LoadTestsFromPythonModule
from launcher.smoke.launch_tests.running import LaunchTestRunner

_MARKS = {"launch_test", "rostest"}


def made(path: Path, parent: Any) -> LaunchTestModule | None:
    """The collector of a file, if its description is marked; pytest reports what fails in it."""
    try:
        module = _imported(path, parent.config)
    except Exception:
        return None
    function = getattr(module, "generate_test_description", None)
    marks = getattr(function, "pytestmark", [])
    if not any(mark.name in _MARKS for mark in marks):
        return None
    collector: LaunchTestModule = LaunchTestModule.from_parent(parent, path=path)
    for mark in marks:
        collector.add_marker(getattr(pytest.mark, mark.name).with_args(*mark.args, **mark.kwargs))
    return collector


def _imported(path: Path, config: Any) -> Any:
    mode = config.getoption("importmode")
    try:
        return import_path(
            path,
            mode=mode,
            root=config.rootpath,
            consider_namespace_packages=config.getini("consider_namespace_packages"),
        )
    except (TypeError, ValueError):  # pytest < 8.1
        return import_path(path, mode=mode, root=config.rootpath)  # type: ignore[call-arg]


class LaunchTestFailure(Exception):
    """Tests of a file have failed."""

    def __init__(self, message: str, results: Mapping[Any, Any]) -> None:
        super().__init__(message)
        self.results = results


class LaunchTestItem(pytest.Item):
    """All runs of a file."""

    def runtest(self) -> None:
        module = _imported(self.path, self.config)
        arguments: list[str] = [
            one for some in self.config.getoption("--launch-args") for one in some
        ]
        runs = LoadTestsFromPythonModule(module, name=self.name)
        runner = LaunchTestRunner(runs, arguments, self.config.get_verbosity() > 1)
        runner.validate()
        results = runner.run()
        if not all(result.wasSuccessful() for result in results.values()):
            raise LaunchTestFailure("some test cases have failed", results)

    def repr_failure(self, excinfo: Any, style: Any = None) -> Any:
        if not isinstance(excinfo.value, LaunchTestFailure):
            return super().repr_failure(excinfo, style)
        return "\n\n".join(
            f"FAIL: {case.id()}\n{text}"
            for result in excinfo.value.results.values()
            for case, text in (*result.errors, *result.failures)
        )

    def reportinfo(self) -> tuple[Path, int, str]:
        return self.path, 0, f"launch tests: {self.name}"


class LaunchTestModule(pytest.File):
    """A file with a test of launch_testing."""

    def collect(self) -> Iterator[pytest.Item]:
        module = _imported(self.path, self.config)
        item: pytest.Item = LaunchTestItem.from_parent(self, name=module.__name__)
        yield item
