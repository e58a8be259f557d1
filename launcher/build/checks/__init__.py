"""What can be known about packages before anything is compiled: errors and warnings with places.

A package with an error cannot be built; one with a warning can.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence

from launcher.build.checks import origins
from launcher.build.checks.cmake import CMakeCheck
from launcher.build.checks.interface_index import InterfaceIndex
from launcher.build.checks.known import Environment
from launcher.build.checks.overlay import check_overlay
from launcher.build.checks.python import check_python
from launcher.build.sources import Found, Package, cycles
from launcher.build.sources.source_text import SourceError, SourceWarning, shown
from launcher.text import did_you_mean, one_of

_FOR_BUILDING = ("depend", "build_depend", "buildtool_depend")
_BUILD_TYPES = ("ament_cmake", "ament_python", "cmake")


def check(
    found: Found,
    env: Mapping[str, str] = os.environ,
    *,
    install: str | None = None,
    only: Iterable[str] | None = None,
) -> list[SourceError]:
    """All that is wrong: of the packages `only`, by default of all, in the order of packages.

    Errors of packages whose package.xml cannot be read come first. SourceWarnings are last.
    `install` is the folder of the workspace's results, which do not count as installed.
    """
    packages = found.packages
    names = {*only} if only is not None else {package.name for package in packages}
    unreadable = {package.name for package in found.unreadable}
    environment = Environment(env, without=[install] if install else [])
    index = InterfaceIndex(packages, environment)
    environment.assumed |= unreadable  # what is wrong with them is reported once
    problems = [*found.errors, *cycles(packages)]
    for package in packages:
        if package.name in names:
            problems += _checked(package, packages, index)
            # It cannot be built either if one that it depends on cannot be read.
            names |= {one.name for one in package.dependencies} & unreadable
    kept = [one for one in problems if one.package is None or only is None or one.package in names]
    return sorted(_once(kept), key=lambda problem: isinstance(problem, SourceWarning))


def errors(problems: Iterable[SourceError]) -> list[SourceError]:
    return [problem for problem in problems if not isinstance(problem, SourceWarning)]


def warnings(problems: Iterable[SourceError]) -> list[SourceWarning]:
    return [problem for problem in problems if isinstance(problem, SourceWarning)]


def _once(problems: Iterable[SourceError]) -> Iterator[SourceError]:
    seen: set[str] = set()
    for problem in problems:
        text = problem.render()
        if text not in seen:
            seen.add(text)
            yield problem


def _checked(
    package: Package, packages: Sequence[Package], index: InterfaceIndex
) -> list[SourceError]:
    problems: list[SourceError] = []
    try:
        problems += _build_type(package)
        if not problems:
            if package.is_python:
                problems += check_python(package)
            else:
                problems += CMakeCheck(package, index).problems()
                problems += check_overlay(package, index.environment)
            problems += _dependencies(package, packages, index.environment, problems)
    except SourceError as error:
        problems.append(error)
    for problem in problems:
        problem.package = package.name
    return problems


def _build_type(package: Package) -> Iterator[SourceError]:
    """A build type that cannot be built, or whose build file is missing."""
    manifest = package.manifest
    if manifest is None:
        return
    type_ = package.build_type
    line = manifest.build_type_line
    if line is None:
        yield from _without_build_type(package)
    elif type_ == "catkin":
        yield manifest.source.error(
            "a package of ROS 1 cannot be built with ROS 2", line, at=type_,
            hint=f"keep it out of the build: touch {shown(package.file('COLCON_IGNORE'))}",
        )  # fmt: skip
    elif type_ not in _BUILD_TYPES:
        known = f"the build types are {one_of(_BUILD_TYPES)}"
        near = did_you_mean(type_, _BUILD_TYPES) or known
        yield manifest.source.error(f"unknown build type '{type_}'", line, at=type_, hint=near)
    else:
        file = "setup.py" if type_ == "ament_python" else "CMakeLists.txt"
        if not package.has(file):
            other = "CMakeLists.txt" if file == "setup.py" else "setup.py"
            fitting = "ament_cmake" if file == "setup.py" else "ament_python"
            hint = f"write {fitting}: there is a {other}" if package.has(other) else None
            message = f"a package of build type {type_} has a {file}, which is missing"
            yield manifest.source.error(message, line, at=type_, hint=hint)


def _without_build_type(package: Package) -> Iterator[SourceError]:
    assert package.manifest is not None
    fitting = next(
        (
            type_
            for file, type_ in (("CMakeLists.txt", "ament_cmake"), ("setup.py", "ament_python"))
            if package.has(file)
        ),
        "ament_cmake",
    )
    yield package.manifest.source.error(
        "package.xml has no build type, which means ROS 1 (catkin)",
        package.manifest.end_line,
        hint=f"add <export><build_type>{fitting}</build_type></export>",
    )


def _dependencies(
    package: Package,
    packages: Sequence[Package],
    environment: Environment,
    problems: Sequence[SourceError],
) -> Iterator[SourceError]:
    """Warnings about dependencies that are missing, and that building does not need.

    What CMakeLists.txt needs is among the `problems` already.
    """
    manifest = package.manifest
    if manifest is None:
        return
    known = environment.packages | environment.assumed | {one.name for one in packages}
    reported = {word for one in problems for word in re.findall(r"[\w-]+", one.message)}
    for one in manifest.dependencies:
        if one.name in known or origins.is_of_system(one.name) or one.name in reported:
            continue
        if one.tag == "test_depend" or origins.is_of_launcher(one.name):
            continue
        if environment.has_cmake(one.name):
            continue
        if one.tag not in _FOR_BUILDING and not origins.is_misspelt(one.name, known):
            continue
        message, hint = origins.missing(one.name, known)
        if one.name == "catkin":
            message, hint = "catkin is the build tool of ROS 1", "write ament_cmake"
        reported.add(one.name)
        yield manifest.source.warning(message, one.line, at=one.name, hint=hint)
