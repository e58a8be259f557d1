"""Checks packages with a CMakeLists.txt, without running CMake."""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Iterator, Sequence

from launcher.base.text import did_you_mean
from launcher.workspace.building.checks import origins
from launcher.workspace.building.checks.interface_index import InterfaceIndex
from launcher.workspace.building.checks.interface_packages import check_interfaces
from launcher.workspace.building.sources import Package
from launcher.workspace.building.sources.cmake_file import Argument, CMakeCommand, CMakeFile
from launcher.workspace.building.sources.source_text import SourceError

_INSTALL_ENDS = (
    "DESTINATION", "TYPE", "PERMISSIONS", "CONFIGURATIONS", "COMPONENT", "RENAME", "OPTIONAL",
    "FILES_MATCHING", "PATTERN", "REGEX", "USE_SOURCE_PERMISSIONS", "FILE_PERMISSIONS",
    "DIRECTORY_PERMISSIONS", "MESSAGE_NEVER", "EXCLUDE",
)  # fmt: skip
_OLDEST = (3, 3)  # whose policies the macros of rosidl need
_OF_CORE = re.compile(r"ament_(package(_xml)?|index_\w+|(execute|register)_extensions?)")
_WITHOUT_GROUP = {"SKIP_GROUP_MEMBERSHIP_CHECK", "SKIP_INSTALL"}  # they leave out what fails


class CMakeCheck:
    """The mistakes in a package's CMakeLists.txt. Raises SourceError if it cannot be read."""

    def __init__(self, package: Package, index: InterfaceIndex) -> None:
        self._package = package
        self._names = index.needed.keys()
        self._index = index
        self._file = index.cmake_file(package) or CMakeFile(package.file("CMakeLists.txt"))
        self._source = self._file.source

    def problems(self) -> Iterator[SourceError]:
        yield from self._minimum()
        yield from self._project()
        yield from self._packages()
        yield from self._commands()
        yield from self._installed()
        yield from check_interfaces(self._package, self._file, self._index)

    def _minimum(self) -> Iterator[SourceError]:
        """Without the policies of CMake 3.3 macros of rosidl fail, and elsewhere those of ament."""
        uses = [one for one in self._file.commands if one.name.startswith(("ament_", "rosidl_"))]
        if not uses or self._file.has("cmake_policy", "include"):
            return
        asked = self._file.named("cmake_minimum_required")
        if not asked and self._file.has("cmake_minimum_required"):
            return
        versions = [_policies(one.words) for one in asked]
        if None in versions or any(one and one >= _OLDEST for one in versions):
            return
        message = "CMakeLists.txt has no cmake_minimum_required()"
        if asked:
            message = "with a CMake before 3.3 the macros of ament and rosidl do not work"
        calls = self._file.named("rosidl_generate_interfaces")
        is_certain = any(not _WITHOUT_GROUP & {*one.words} for one in calls)
        report = self._source.error if is_certain else self._source.warning
        yield report(
            message,
            asked[0].line if asked else None,
            at="VERSION" if asked else None,
            hint=f"{'write' if asked else 'add'} cmake_minimum_required(VERSION 3.8)"
            + ("" if asked else " as the first line"),
        )

    def _project(self) -> Iterator[SourceError]:
        if self._package.build_type != "ament_cmake":
            return  # CMake needs no project(), and colcon no special name
        projects = self._file.named("project")
        end = next(iter(self._file.named("ament_package")), None)
        is_certain = end is not None and not self._file.may_do_more
        report = self._source.error if is_certain else self._source.warning
        if not projects:
            if not self._file.has("project", "include"):
                hint = f"add project({self._package.name}) as the second line"
                yield report("CMakeLists.txt has no project()", hint=hint)
            return
        before = [one for one in projects if end is None or one.line < end.line]
        project = before[-1] if before else projects[0]
        if project.words and project.words[0] != self._package.name:
            name = project.words[0]
            yield report(
                f"project() is called '{name}', package.xml '{self._package.name}'",
                project.line,
                at=name,
                hint=f"write project({self._package.name})",
            )

    # ---- find_package

    def _packages(self) -> Iterator[SourceError]:
        for command in self._file.named("find_package"):
            if "REQUIRED" in command.words:
                yield from self._found(command)

    def _found(self, command: CMakeCommand) -> Iterator[SourceError]:
        argument = command.arguments[0]
        name, line = argument.text, argument.line
        environment = self._index.environment
        is_elsewhere = self._index.may_be_elsewhere(self._package, name)
        is_elsewhere = is_elsewhere or bool({"NAMES", "PATHS", "HINTS"} & {*command.words})
        report = self._source.warning if is_elsewhere else self._source.error
        if name in self._names:
            # colcon passes on what all that is needed, directly or not, has installed.
            if name not in {*self._index.before[self._package.name], self._package.name}:
                is_there = environment.is_merged or environment.has_cmake(name)
                report = self._source.warning if is_there else report
                message = f"package.xml does not name '{name}' as a dependency: "
                message += "colcon may build it later"
                hint = f"add <depend>{name}</depend> to package.xml"
                yield report(message, line, at=name, hint=hint)
            return
        if self._index.environment.has_cmake(name) or self._has_module(name):
            return
        known = self._names | self._index.environment.cmake_names
        asked = {one.name for one in self._package.dependencies}
        if (name in asked and not origins.is_of_system(name)) or origins.is_of_ros(name, known):
            message, hint = origins.missing(name, known)
            yield report(message, line, at=name, hint=hint)
        # Others may be libraries of the system that CMake finds in its own ways.

    def _has_module(self, name: str) -> bool:
        """Whether the package, or one that it needs, has a module for find_package."""
        pattern = f"**/Find{glob.escape(name)}.cmake"
        folders = self._index.folders(self._package)
        found = (glob.glob(pattern, root_dir=folder, recursive=True) for folder in folders)
        return any(found) or self._index.environment.has_module(name)

    # ---- commands

    def _commands(self) -> Iterator[SourceError]:
        """Commands of packages that are not looked for, and a missing ament_package()."""
        ours = [one for one in self._file.commands if one.name.startswith("ament_")]
        if ours and not self._file.has("find_package") and not self._file.may_do_more:
            message = f"{ours[0].name}() needs find_package(ament_cmake REQUIRED) before it"
            # Those of ament_cmake_core are there: `toolchain/wheels.cmake` has looked for it.
            is_core = all(map(_OF_CORE.fullmatch, (one.name for one in ours)))
            report = self._source.warning if is_core else self._source.error
            yield report(message, ours[0].line, at=ours[0].name)
        if self._package.build_type != "ament_cmake":
            return
        end = self._file.named("ament_package", "ament_auto_package")
        if not end and not self._file.has("ament_package", "ament_auto_package", "include"):
            yield self._source.warning(
                "CMakeLists.txt does not end with ament_package(): the package is not found "
                "after it is built",
                len(self._source.text.rstrip().splitlines()) or 1,
                hint="add ament_package() as the last line",
            )

    # ---- install

    def _installed(self) -> Iterator[SourceError]:
        """Files and folders to install that do not exist."""
        for command in self._file.named("install"):
            words = command.words
            if not words or words[0] not in ("DIRECTORY", "FILES", "PROGRAMS"):
                continue
            if {"OPTIONAL", "EXCLUDE_FROM_ALL"} & {*words}:
                continue
            for argument in command.arguments[1:]:
                if argument.text in _INSTALL_ENDS:
                    break
                yield from self._exists(argument, is_folder=words[0] == "DIRECTORY")

    def _exists(self, argument: Argument, *, is_folder: bool) -> Iterator[SourceError]:
        text = argument.text
        path = os.path.join(self._file.folder, text)
        if os.path.exists(path) or ";" in text or not text:
            return
        if not os.path.realpath(path).startswith(os.path.realpath(self._file.folder) + os.sep):
            return  # of the build folder, or of the system
        kind = "folder" if is_folder else "file"
        try:
            beside = os.listdir(os.path.dirname(path.rstrip("/")))
        except OSError:
            beside = []
        name = os.path.basename(text.rstrip("/"))
        hint = did_you_mean(name, [one for one in beside if not one.startswith(".")])
        is_made = self._file.makes_files or self._file.has(
            "add_custom_command", "add_custom_target"
        )
        report = self._source.warning if is_made else self._source.error
        yield report(
            f"the {kind} '{text}' to install does not exist",
            argument.line or None,
            at=text,
            hint=hint or (f"create it: mkdir {text}" if is_folder else None),
        )


def _policies(words: Sequence[str]) -> tuple[int, ...] | None:
    """The version whose policies cmake_minimum_required sets; None if it is not known."""
    found = re.search(r"\bVERSION (?:[\d.]+\.\.\.)?(\d+)\.(\d+)", " ".join(words))
    return (int(found[1]), int(found[2])) if found else None
