"""Messages about tests of launch_testing and launch_pytest, which are not launch files."""

from __future__ import annotations

import shlex
from types import ModuleType

from launcher.base.program import program
from launcher.base.text import shown_path
from launcher.language.diagnostics import source_code
from launcher.language.diagnostics.error_details import details
from launcher.language.diagnostics.origin import FileLine

_FUNCTION = "generate_test_description"


def explain(error: BaseException, module: ModuleType, path: str) -> None:
    """Attach to the error about a file that has nothing to launch that the file is a test."""
    package = _package_of(module)
    if package is None:
        return
    function = source_code.function_at(path, _FUNCTION)
    what = "it is" if function is None else f"{_FUNCTION}() makes it"
    known = details(error)
    known.message = f"{what} a test of {package}, not a launch file"
    known.place = FileLine(path, 1 if function is None else function.lineno)
    known.hint = _how_to_run(package, path)
    known.word = package if function is None else _FUNCTION


def _package_of(module: ModuleType) -> str | None:
    names = vars(module)
    if "launch_pytest" in names:
        return "launch_pytest"
    return "launch_testing" if _FUNCTION in names else None


def _how_to_run(package: str, path: str) -> str:
    command = "python -m pytest" if package == "launch_pytest" else f"{program()} launch-test"
    return f"run it with {command} {shlex.quote(shown_path(path))}"
