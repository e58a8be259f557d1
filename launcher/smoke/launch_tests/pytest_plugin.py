"""The pytest plugin for tests of launch_testing and launch_pytest; installed ones go first.

pytest loads this module in every run, so it imports the rest only when there is such a test.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from launcher.language.compat import is_installed
from launcher.language.compat.on_path_modules import extend_path

_FUNCTION = b"generate_test_description"
_MARKS = {
    "launch_testing": (
        "launch_test: a generate_test_description function with a test of launch_testing",
        "rostest: the same with ROS",
    ),
    "launch_pytest": ("launch(fixture, shutdown=False): a test of launch_pytest",),
}


def pytest_addoption(parser: pytest.Parser) -> None:
    if not is_installed("launch_testing"):
        parser.getgroup("launcher").addoption(
            "--launch-args",
            action="append",
            nargs="*",
            default=[],
            metavar="NAME:=VALUE",
            help="arguments for tests of launch_testing",
        )


def pytest_configure(config: pytest.Config) -> None:
    extend_path()
    for package, marks in _MARKS.items():
        if is_installed(package):
            continue
        for mark in marks:
            config.addinivalue_line("markers", mark)
        if package == "launch_testing":
            _check_arguments(config)
            config.pluginmanager.register(_TestModules(), "launcher-launch-testing")
        else:
            from launcher.smoke.launch_tests import launch_items

            config.pluginmanager.register(launch_items, "launcher-launch-pytest")


def _check_arguments(config: pytest.Config) -> None:
    given = [one for some in config.getoption("--launch-args") for one in some]
    if not given:
        return
    from launcher.language.ros.cli_api import parse_launch_arguments
    from launcher.smoke.launch_tests.arguments import hint_of

    for argument in given:
        try:
            parse_launch_arguments([argument])
        except RuntimeError as error:
            hint = hint_of(argument) or "a -- ends the arguments, before files and folders"
            raise pytest.UsageError(f"--launch-args: {error}\nhint: {hint}") from None


class _TestModules:
    """Collects files whose generate_test_description has one of the marks; no launch files."""

    def pytest_ignore_collect(self, collection_path: Path) -> bool | None:
        return True if collection_path.name.endswith(".launch.py") else None

    @pytest.hookimpl(tryfirst=True)
    def pytest_pycollect_makemodule(self, module_path: Path, parent: Any) -> Any:
        try:
            source = module_path.read_bytes()
        except OSError:
            return None
        if _FUNCTION not in source:
            return None
        from launcher.smoke.launch_tests.test_modules import made

        return made(module_path, source, parent)
