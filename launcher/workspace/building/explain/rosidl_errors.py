"""Failures of rosidl, and of the compiler in what rosidl has generated.

The checks before the build find these mistakes; they come this far if CMakeLists.txt lists the
files in a way that only CMake understands.
"""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Iterator

from launcher.base.errors import LauncherError
from launcher.workspace.building.checks.interface_files import SUFFIXES, InterfaceFile
from launcher.workspace.building.checks.interface_names import snake_case
from launcher.workspace.building.explain.build_output import BuildOutput
from launcher.workspace.building.sources.source_text import SourceError, SourceWarning

_SIGNS = ("rosidl_adapter", "rosidl_generator", "rosidl_parser", "rosidl_typesupport")
_GENERATED = re.compile(r"/(?:msg|srv|action)/detail/(\w+?)__\w+\.\w+:\d+:\d+: (?:fatal )?error: ")


def explain(output: BuildOutput) -> LauncherError | None:
    """The mistake in an interface file that made a generator or a compiler fail."""
    if not output.has(*_SIGNS) or not re.search(r"Traceback|error: ", output.text):
        return None
    files = list(_files(output))
    for file in files:
        for problem in file.problems:
            if not isinstance(problem, SourceWarning):
                return problem
    return _unknown_package(output, files) or _unknown_type(output, files) or _generated(output)


def _files(output: BuildOutput) -> Iterator[InterfaceFile]:
    for folder in ("msg", "srv", "action", "*/msg", "*/srv", "*/action"):
        pattern = os.path.join(glob.escape(output.folder), folder, "**")
        for path in sorted(glob.glob(pattern, recursive=True)):
            if path.endswith(SUFFIXES):
                try:
                    yield InterfaceFile(output.package, path)
                except SourceError:
                    continue


def _unknown_package(output: BuildOutput, files: list[InterfaceFile]) -> LauncherError | None:
    found = re.search(r"^KeyError: '(\w+)'$", output.text, re.MULTILINE)
    if found is None:
        return None
    for file in files:
        for one in file.references:
            if one.package == found[1]:
                return file.source.error(
                    f"'{one.package}' is missing in the DEPENDENCIES of rosidl_generate_interfaces",
                    one.line,
                    at=one.written,
                )
    return None


def _unknown_type(output: BuildOutput, files: list[InterfaceFile]) -> LauncherError | None:
    found = re.search(r"FileNotFoundError: .*/(\w+)/msg/(\w+)\.json'", output.text)
    if found is None:
        return None
    for file in files:
        for one in file.references:
            if (one.package, one.name) == found.groups():
                message = f"unknown type '{one.written}', or its file is not listed"
                return file.source.error(message, one.line, at=one.written)
    return None


def _generated(output: BuildOutput) -> LauncherError | None:
    """An error in a file that is generated from an interface file."""
    found = _GENERATED.search(output.text)
    if found is None:
        return None
    for path in glob.glob(os.path.join(glob.escape(output.folder), "*", "*")):
        name, suffix = os.path.splitext(os.path.basename(path))
        if suffix in SUFFIXES and snake_case(name) == found[1]:
            return output.error("what is generated from this file cannot be compiled", path)
    return None
