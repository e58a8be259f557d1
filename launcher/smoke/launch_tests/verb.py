"""`launch-test FILE [name:=value ...]`: run a test of launch_testing.

It is the program `launch_test`, too. An installed launch_testing runs the test, if there is one, on
the launcher's `launch`.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import sys
from collections.abc import Sequence
from types import ModuleType
from typing import Any

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode, UsageError
from launcher.base.model.run_options import RunOptions
from launcher.base.option import DEBUG, option
from launcher.base.text import shown_path
from launcher.base.verb_table import VERBS
from launcher.language.compat import is_installed
from launcher.language.ros.cli_api import (
    parse_launch_arguments,
    print_arguments_of_launch_description,
)
from launcher.launch.launch_service_run import load_libraries, script_vocabulary
from launcher.smoke.launch_tests.arguments import hint_of
from launcher.smoke.launch_tests.file_faults import fault_line, fault_text, skips
from launcher.smoke.launch_tests.test_calls import LaunchTerminated

_FUNCTION = "generate_test_description"

COMMAND = Command(
    "launch-test",
    VERBS["launch-test"],
    arguments=(
        option("FILE", "a Python file with generate_test_description()"),
        option("[NAME:=VALUE ...]", "arguments of the description", name="values"),
    ),
    options=(
        option("-v, --verbose", "print messages of level DEBUG, too"),
        option("-s, --show-args, --show-arguments", "print the arguments, and run nothing"),
        option("--package-name NAME", "the package in the report (default: the name of the file)"),
        option("--junit-xml FILE", "write a JUnit report"),
        DEBUG,
    ),
)


def main(words: Sequence[str]) -> int:
    """Run the tests; 0 if all have passed, 1 if not, 2 for a file that cannot be used."""
    options = COMMAND.parse(words)
    if not os.path.isfile(options.file):
        raise UsageError(f"Test file '{options.file}' does not exist")
    load_libraries()
    with script_vocabulary(RunOptions(console=False)):
        if is_installed("launch_testing"):
            return _run_installed(words)
        return _run(options)


def _run_installed(words: Sequence[str]) -> int:
    module = importlib.import_module("launch_testing.launch_test")
    argv, sys.argv = sys.argv, ["launch_test", *words]
    try:
        module.main()
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else int(ended.code is not None)
    finally:
        sys.argv = argv
    return 0


def _run(options: Parsed) -> int:
    _check_arguments(options.values)
    path = os.path.abspath(options.file)
    stem = os.path.splitext(os.path.basename(path))[0]
    package = options.package_name or stem
    try:
        results = _results(options, path, package, f"{package}.{stem}.launch_tests")
    except LaunchTerminated:
        return ExitCode.TERMINATED
    except (UsageError, KeyboardInterrupt):
        raise
    except BaseException as error:
        if isinstance(error, skips()):
            from launcher.smoke.launch_tests.results import skipped_file

            print(f"{shown_path(path)} is skipped: {error}")
            results = {f"{package}.{stem}.launch_tests": skipped_file(package, stem, str(error))}
        elif options.debug and isinstance(error, Exception):
            raise
        else:
            line = fault_line(error, path)
            where = shown_path(path) if line is None else f"{shown_path(path)}:{line}"
            raise UsageError(fault_text(error, path), where=where) from error
    if options.junit_xml is not None and not options.show_arguments:
        from launcher.smoke.launch_tests.junit import unittestResultsToXml

        report = unittestResultsToXml(name=f"{package}.{stem}", test_results=results)
        report.write(options.junit_xml, encoding="utf-8", xml_declaration=True)
    return int(not all(result.wasSuccessful() for result in results.values()))


def _check_arguments(words: Sequence[str]) -> None:
    for word in words:
        try:
            parse_launch_arguments([word])
        except RuntimeError as error:
            hint = "launch-test runs one file" if os.path.exists(word) else hint_of(word)
            raise UsageError(str(error), hint=hint) from None


def _results(options: Parsed, path: str, package: str, name: str) -> dict[Any, Any]:
    """The results by run; none if the arguments are printed instead."""
    from launcher.smoke.launch_tests.loading import LoadTestsFromPythonModule
    from launcher.smoke.launch_tests.running import LaunchTestRunner

    runs = LoadTestsFromPythonModule(_module(package, path), name=name)
    runner = LaunchTestRunner(runs, options.values, options.verbose)
    runner.validate()
    if options.show_arguments:
        description = runs[0].get_launch_description()
        print_arguments_of_launch_description(launch_description=description)
        return {}
    return runner.run()


def _module(name: str, path: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise UsageError(f"{shown_path(path)} is no Python file")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    if not hasattr(module, _FUNCTION):
        raise UsageError(
            f"{shown_path(path)} has no function {_FUNCTION}()",
            hint="tests of launch_pytest, and others, are run by pytest",
        )
    return module
