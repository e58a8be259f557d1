"""Tests of launch_testing as pytest collects them: one item for a file.

pytest asks for the collectors of all files of a folder, also where it runs only one of them. So
a file is only read for that, and imported when it is collected: a fault, a skip or an exit in it
is its own then.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from launcher.language.diagnostics.origin import is_own_file
from launcher.smoke.launch_tests.file_faults import fault_line, fault_text
from launcher.smoke.launch_tests.loading import LoadTestsFromPythonModule
from launcher.smoke.launch_tests.running import LaunchTestRunner

_MARKS = {"launch_test", "rostest"}
_FUNCTION = "generate_test_description"


def made(path: Path, source: bytes, parent: Any) -> LaunchTestModule | None:
    """The collector of a file that has a description; pytest reports what cannot be read."""
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None
    if path.name == "__init__.py" or not any(map(_names_description, ast.walk(tree))):
        return None
    collector: LaunchTestModule = LaunchTestModule.from_parent(parent, path=path)
    return collector


def _names_description(node: ast.AST) -> bool:
    """Whether this defines or imports the function: a comment or text does not."""
    if isinstance(node, ast.alias):
        return _FUNCTION in (node.name, node.asname)
    if isinstance(node, ast.Name):
        return node.id == _FUNCTION and isinstance(node.ctx, ast.Store)
    return isinstance(node, ast.FunctionDef) and node.name == _FUNCTION


class LaunchTestFailure(Exception):
    """Tests of a file have failed."""

    def __init__(self, message: str, results: Mapping[Any, Any]) -> None:
        super().__init__(message)
        self.results = results


class LaunchTestItem(pytest.Item):
    """All runs of a file."""

    def runtest(self) -> None:
        collector: Any = self.parent
        arguments: list[str] = [
            one for some in self.config.getoption("--launch-args") for one in some
        ]
        runs = LoadTestsFromPythonModule(collector.obj, name=self.name)
        runner = LaunchTestRunner(runs, arguments, self.config.get_verbosity() > 1)
        runner.validate()
        results = runner.run()
        if not all(result.wasSuccessful() for result in results.values()):
            raise LaunchTestFailure("some test cases have failed", results)

    def repr_failure(self, excinfo: Any, style: Any = None) -> Any:
        if not isinstance(excinfo.value, LaunchTestFailure):
            return self._shown(excinfo, style)
        return "\n\n".join(
            f"FAIL: {case.id()}\n{text}"
            for result in excinfo.value.results.values()
            for case, text in (*result.errors, *result.failures)
        )

    def _shown(self, excinfo: Any, style: Any) -> Any:
        """What the description has raised: without the frames of pytest and the launcher."""
        if self.config.getoption("fulltrace"):
            return super().repr_failure(excinfo, style)
        path = str(self.path)
        own = excinfo.traceback.cut(path=path).filter(lambda one: not is_own_file(str(one.path)))
        if fault_line(excinfo.value, path) is None or not own:
            return f"{self.path.name}: {fault_text(excinfo.value, path)}"
        excinfo.traceback = own
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int, str]:
        return self.path, 0, f"launch tests: {self.name}"


class LaunchTestModule(pytest.Module):
    """A file with a description: a test of launch_testing if that has a mark, else a usual one."""

    def collect(self) -> Iterator[pytest.Item | pytest.Collector]:
        try:
            module = self.obj
        except SystemExit as ended:
            path = str(self.path)
            text = f"{path}:{fault_line(ended, path)}: {fault_text(ended, path)}"
            raise self.CollectError(text) from ended
        marks = getattr(getattr(module, _FUNCTION, None), "pytestmark", [])
        if not any(mark.name in _MARKS for mark in marks):
            yield from super().collect()
            return
        for mark in marks:
            again = getattr(pytest.mark, mark.name).with_args(*mark.args, **mark.kwargs)
            self.add_marker(again)
        item: pytest.Item = LaunchTestItem.from_parent(self, name=module.__name__)
        yield item
