"""What can be known about packages before anything is compiled: errors and warnings with places.

A package with an error cannot be built; one with a warning can.
"""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache
from importlib import metadata

from launcher.base.text import did_you_mean, one_of, several
from launcher.packages.package_origins import is_of_launcher
from launcher.workspace.building.checks import origins
from launcher.workspace.building.checks.cmake_check import CMakeCheck
from launcher.workspace.building.checks.interface_index import InterfaceIndex
from launcher.workspace.building.checks.known import Environment
from launcher.workspace.building.checks.python_check import check_python
from launcher.workspace.building.sources import FoundPackages, Package, cycles
from launcher.workspace.building.sources.source_text import SourceError, SourceWarning, shown

_FOR_BUILDING = ("depend", "build_depend", "buildtool_depend")
_BUILD_TYPES = ("ament_cmake", "ament_python", "cmake")


def check(
    found: FoundPackages,
    env: Mapping[str, str] = os.environ,
    *,
    install: str | None = None,
    only: Iterable[str] | None = None,
    definitions: Collection[str] = (),
    is_merged: bool = False,
) -> list[SourceError]:
    """All that is wrong: of the packages `only`, by default of all, in the order of packages.

    Errors of packages whose package.xml cannot be read come first. SourceWarnings are last.
    `install` is the folder of the workspace's results, which do not count as installed;
    `definitions` are the names of what is defined for CMake, with `is_merged` all packages are
    installed into one prefix.
    """
    packages = found.packages
    names = {*only} if only is not None else {package.name for package in packages}
    unreadable = {package.name for package in found.unreadable}
    without = [install] if install else []
    environment = Environment(env, without=without, definitions=definitions, is_merged=is_merged)
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
        problems += _build_type(package, index)
        if not errors(problems):
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


def _build_type(package: Package, index: InterfaceIndex) -> Iterator[SourceError]:
    """A build type that cannot be built, or whose build file is missing."""
    manifest = package.manifest
    if manifest is None:
        return
    type_ = package.build_type
    line = manifest.build_type_line
    if type_ == "catkin":
        yield from _catkin(package, index)
    elif type_ not in (known := _build_types()):
        near = did_you_mean(type_, known) or f"the build types are {one_of(known)}"
        yield manifest.source.error(f"unknown build type '{type_}'", line, at=type_, hint=near)
    elif type_ in _BUILD_TYPES:
        file = "setup.py" if type_ == "ament_python" else "CMakeLists.txt"
        if not package.has(file):
            other = "CMakeLists.txt" if file == "setup.py" else "setup.py"
            fitting = "ament_cmake" if file == "setup.py" else "ament_python"
            hint = f"write {fitting}: there is a {other}" if package.has(other) else None
            message = f"a package of build type {type_} has a {file}, which is missing"
            yield manifest.source.error(message, line, at=type_, hint=hint)


@cache
def _build_types() -> tuple[str, ...]:
    """The build types of colcon, with those of its extensions that are installed."""
    names = (one.name for one in metadata.entry_points(group="colcon_core.task.build"))
    others = {name.removeprefix("ros.") for name in names if name.startswith("ros.")}
    return (*_BUILD_TYPES, *sorted(others - {*_BUILD_TYPES, "catkin"}))


def _catkin(package: Package, index: InterfaceIndex) -> Iterator[SourceError]:
    """The build type of ROS 1, and of packages that give none: colcon builds them by CMake.

    That cannot succeed if they look for catkin, or have no CMakeLists.txt.
    """
    manifest = package.manifest
    assert manifest is not None
    file = index.cmake_file(package) if package.has("CMakeLists.txt") else None
    found = file.named("find_package") if file else []
    is_ros1 = any({"catkin", "REQUIRED"} <= {*one.words} for one in found)
    is_ros1 = is_ros1 and not index.environment.has_cmake("catkin")
    cannot = is_ros1 or not package.has("CMakeLists.txt")
    report = manifest.source.error if cannot else manifest.source.warning
    if manifest.build_type_line is None:
        fitting = "ament_cmake" if file or not package.has("setup.py") else "ament_python"
        hint = f"add <export><build_type>{fitting}</build_type></export>"
        at, line = manifest.misspelt or (None, manifest.end_line)
        hint = "did you mean 'build_type'?" if at else hint
        message = "package.xml has no build type, which means ROS 1 (catkin)"
        yield report(message, line, at=at, hint=hint)
    elif cannot:
        yield manifest.source.error(
            "a package of ROS 1 cannot be built with ROS 2", manifest.build_type_line, at="catkin",
            hint=f"keep it out of the build: touch {shown(package.file('COLCON_IGNORE'))}",
        )  # fmt: skip


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
        if one.tag == "test_depend" or is_of_launcher(one.name):
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


_COMMENT = re.compile(r"(^|\s)#.*$", re.MULTILINE)
_SHOWN = 3  # names in a message


def check_overlay(package: Package, environment: Environment) -> Iterator[SourceError]:
    """A warning if interfaces differ from the installed ones, and installed packages use these.

    The libraries of such packages are compiled for the old fields, but get the new messages.
    """
    installed = environment.interfaces(package.name)
    if package.manifest is None or not installed:
        return
    users = [
        name
        for name in sorted(environment.interface_packages() - {package.name})
        if package.name in environment.run_dependencies(name)
    ]
    changed = sorted(name for name in installed if users and _differs(package, environment, name))
    if changed:
        yield package.manifest.source.warning(
            f"{package.name} hides the installed package, which has other fields in "
            f"{several(changed, _SHOWN)}: {several(users, _SHOWN)} would read wrong data",
            package.manifest.name_line,
            at=package.name,
            hint="keep the installed fields, and put others into a package of another name",
        )


def _differs(package: Package, environment: Environment, interface: str) -> bool:
    """Whether a definition such as `msg/Header` is another one, or missing in the workspace."""
    file = f"{interface}.{os.path.dirname(interface)}"
    for prefix in environment.prefixes:
        old = _fields(os.path.join(prefix, "share", package.name, file))
        if old is not None:
            return old != _fields(package.file(file))
    return False


def _fields(path: str) -> list[list[str]] | None:
    """The lines of a definition as words, without comments."""
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read()
    except (OSError, UnicodeDecodeError):
        return None
    return [line.split() for line in _COMMENT.sub("", text).splitlines() if line.strip()]
