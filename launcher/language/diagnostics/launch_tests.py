"""Messages about tests of launch_testing and launch_pytest, which are not launch files."""

from __future__ import annotations

import shlex
import shutil
from types import ModuleType

from launcher.base.program import program
from launcher.base.text import shown_path
from launcher.language.diagnostics import source_code
from launcher.language.diagnostics.error_details import details
from launcher.language.diagnostics.origin import FileLine

_FUNCTION = "generate_test_description"
# Package -> the program that runs its tests.
PROGRAMS = {
    "launch_testing": "launch_test",
    "launch_testing_ros": "launch_test",
    "launch_pytest": "pytest",
}


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
    known.hint = how_to_run(package, path)
    known.word = package if function is None else _FUNCTION


def _package_of(module: ModuleType) -> str | None:
    names = vars(module)
    if "launch_pytest" in names:
        return "launch_pytest"
    return "launch_testing" if _FUNCTION in names else None


def how_to_run(package: str, path: str | None = None) -> str:
    """Which program runs the test at the path, or tests of the package, and what replaces it."""
    name = PROGRAMS[package]
    it, file = ("it", shlex.quote(shown_path(path))) if path else (f"tests of {package}", "FILE")
    is_missing = name == "pytest" or shutil.which(name) is None
    needed = f" (ROS 2's package {package})" if is_missing else ""
    own = f"without {package}: {program()} smoke, or the pytest fixture launched_system"
    return f"run {it} with {name} {file}{needed}; {own}"
