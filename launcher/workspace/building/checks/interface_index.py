"""The interfaces of the workspace and of the environment, by package."""

from __future__ import annotations

import contextlib
import glob
import os
import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from functools import cached_property

from launcher.base.text import suggest
from launcher.workspace.building.checks.interface_files import SUFFIXES
from launcher.workspace.building.checks.known import Environment
from launcher.workspace.building.sources import Package, dependencies_within, with_dependencies
from launcher.workspace.building.sources.cmake_file import CMakeCommand, CMakeFile
from launcher.workspace.building.sources.source_text import PackageText, SourceError

_CALL = "rosidl_generate_interfaces"
_EXPORTING = ("ament_export_dependencies", "ament_package")
_FLAGS = ("ADD_LINTER_TESTS", "SKIP_INSTALL", "SKIP_GROUP_MEMBERSHIP_CHECK")
_KEYWORDS = (*_FLAGS, "DEPENDENCIES", "LIBRARY_NAME")
_FOLDERS = ("msg", "srv", "action")
# What rosidl adds to DEPENDENCIES for services and actions.
IMPLICIT = ("service_msgs", "action_msgs")
# A word for a folder of the package, or for the folders that are searched already.
_OWN = re.compile(r"\$\{(CMAKE(_CURRENT)?_(SOURCE|LIST)_DIR|\w+_SOURCE_DIR|CMAKE_MODULE_PATH)\}")
_MODULES = re.compile(r"\b(?:set|list)\s*\(([^()]*\bCMAKE_MODULE_PATH\b[^()]*)\)")
_WORDS = ("APPEND", "PREPEND", "INSERT", "CMAKE_MODULE_PATH")


class Generated:
    """A call of rosidl_generate_interfaces: its files and DEPENDENCIES, each with its line.

    `misspelt` are words that look like a keyword, with its line and that keyword, which is taken
    to be meant.
    """

    def __init__(self, command: CMakeCommand) -> None:
        self.line = command.line
        self.is_complete = command.is_complete
        self.files: list[tuple[str, int]] = []
        self.dependencies: list[tuple[str, int]] = []
        self.misspelt: list[tuple[str, int, str]] = []
        target = self.files
        for argument in command.arguments[1:]:
            keyword = _keyword(argument.text, is_file=target is self.files)
            if keyword is not None and keyword != argument.text:
                self.misspelt.append((argument.text, argument.line, keyword))
            if keyword in _FLAGS:
                continue
            if keyword == "DEPENDENCIES":
                target = self.dependencies
            elif keyword == "LIBRARY_NAME":
                target = []  # its value is neither
            else:
                target += [(text, argument.line) for text in argument.text.split(";") if text]


class InterfaceIndex:
    """Which interfaces there are, and which packages a package can use them from."""

    def __init__(self, packages: Sequence[Package], environment: Environment) -> None:
        self.environment = environment
        self.needed = dependencies_within(packages)
        self.before = {one: with_dependencies(packages, [one]) - {one} for one in self.needed}
        self._packages = {package.name: package for package in packages}
        self._files: dict[str, CMakeFile | None] = {}
        self._exports: dict[str, set[str]] = {}
        self._interfaces: dict[str, set[str]] = {}

    def may_be_elsewhere(self, package: Package, name: str) -> bool:
        """Whether CMake may find another package that only the package, or options, name."""
        return self.environment.looks_elsewhere or looks_elsewhere(package, name)

    def folders(self, package: Package) -> list[str]:
        """The folders of a package and of all of the workspace that it needs."""
        below = sorted(self.before[package.name] & self._packages.keys())
        return [package.folder, *(self._packages[name].folder for name in below)]

    def cmake_file(self, package: Package) -> CMakeFile | None:
        """The CMakeLists.txt of a package, read once; None if it cannot be read."""
        if package.name not in self._files:
            try:
                self._files[package.name] = CMakeFile(package.file("CMakeLists.txt"))
            except SourceError:
                self._files[package.name] = None
        return self._files[package.name]

    def generated(self, package: Package) -> list[Generated]:
        file = self.cmake_file(package) if package.has("CMakeLists.txt") else None
        return [Generated(one) for one in file.named(_CALL)] if file else []

    def is_in_workspace(self, package: str) -> bool:
        return package in self._packages

    def is_complete(self, package: str) -> bool:
        """Whether all interfaces of a package are known: not of one in the workspace if its
        CMakeLists.txt may list others.
        """
        source = self._packages.get(package)
        if source is None:
            return True
        file = self.cmake_file(source) if source.has("CMakeLists.txt") else None
        if file is None or file.may_do_more:
            return False
        is_conditional = any(one.name == _CALL for one in file.conditional)
        return not is_conditional and all(call.is_complete for call in self.generated(source))

    def is_plain(self, package: str) -> bool:
        """Whether it is known what find_package brings of a package, besides itself."""
        source = self._packages.get(package)
        if source is None:
            return package in self.environment.packages
        file = self.cmake_file(source) if source.has("CMakeLists.txt") else None
        if file is None or file.may_do_more:
            return False
        ends = [one for one in (*file.commands, *file.conditional) if one.name in _EXPORTING]
        return all(one.is_complete and "CONFIG_EXTRAS" not in one.words for one in ends)

    def are_plain(self, packages: Collection[str]) -> bool:
        """Whether `reachable` has all that can be used with these packages."""
        below = self.reachable(packages) & self._packages.keys()
        return all(map(self.is_plain, {*packages, *below}))

    def has(self, package: str) -> bool:
        """Whether the package has interfaces."""
        return bool(self.of(package))

    def of(self, package: str) -> set[str]:
        """`msg/String`, ... of a package; of one in the workspace what it builds, or may build."""
        if package not in self._interfaces:
            self._interfaces[package] = self._read_interfaces(package)
        return self._interfaces[package]

    def _read_interfaces(self, package: str) -> set[str]:
        source = self._packages.get(package)
        if source is None:
            return self.environment.interfaces(package)
        calls = self.generated(source)
        listed = [file for call in calls for file, _ in call.files]
        if not calls or not self.is_complete(package):
            listed += files_of(source)
        return {name for name in map(interface_name, listed) if name}

    @cached_property
    def packages(self) -> list[str]:
        """All packages with interfaces, sorted."""
        own = {name for name in self._packages if self.has(name)}
        return sorted(own | self.environment.interface_packages())

    @cached_property
    def messages(self) -> list[str]:
        """`package/Type` of all messages."""
        return sorted(
            f"{package}/{name.removeprefix('msg/')}"
            for package in self.packages
            for name in self.of(package)
            if name.startswith("msg/")
        )

    def reachable(self, packages: Iterable[str], *, implicit: Iterable[str] = IMPLICIT) -> set[str]:
        """The packages whose interfaces can be used with these in DEPENDENCIES."""
        found: set[str] = set()
        waiting = {*packages, *implicit}
        while waiting:
            found |= waiting
            waiting = {below for name in waiting for below in self._exported(name)} - found
        return found

    def _exported(self, package: str) -> set[str]:
        if package not in self._exports:
            self._exports[package] = {*self._read_exports(package)}
        return self._exports[package]

    def _read_exports(self, package: str) -> Iterator[str]:
        source = self._packages.get(package)
        if source is None:
            yield from self.environment.run_dependencies(package)
            return
        for call in self.generated(source):
            yield from (name for name, _ in call.dependencies)
        file = self.cmake_file(source)
        for command in (*file.commands, *file.conditional) if file else ():
            if command.name == "ament_export_dependencies":
                yield from command.words


def _keyword(word: str, *, is_file: bool) -> str | None:
    """The keyword that a word is, or is similar to; files and packages are neither."""
    if word in _KEYWORDS:
        return word
    is_candidate = re.fullmatch(r"[A-Za-z_]+" if is_file else "[A-Z_]+", word)
    return suggest(word.upper(), _KEYWORDS) if is_candidate else None


def interface_name(path: str) -> str | None:
    """`msg/String` for `msg/String.msg` and `msg/text/String.msg`; None without a folder.

    Only of .idl files the folder counts.
    """
    folder = folder_of(path)
    name, suffix = os.path.splitext(os.path.basename(path.rpartition(":")[2]))
    kind = folder if suffix == ".idl" else suffix.removeprefix(".")
    return f"{kind}/{name}" if folder else None


def folder_of(path: str) -> str:
    """`msg` for `msg/String.msg`, as rosidl has it: also behind the colon of an absolute path."""
    return os.path.basename(os.path.dirname(path.rpartition(":")[2]))


def files_of(package: Package) -> list[str]:
    """The interface files in the usual folders of a package, relative to it."""
    found = (
        os.path.join(folder, path)
        for folder in _FOLDERS
        for path in glob.glob("**", root_dir=package.file(folder), recursive=True)
    )
    return sorted(path for path in found if path.endswith(SUFFIXES))


def looks_elsewhere(package: Package, name: str) -> bool:
    """Whether they name other folders, for all packages or for the one of this name."""
    places = rf"CMAKE_PREFIX_PATH|FetchContent|\b{re.escape(name)}_(DIR|ROOT)\b"
    return any(
        re.search(places, text) or not all(map(_OWN.match, _module_folders(text)))
        for text in _texts(package)
    )


def _texts(package: Package) -> Iterator[str]:
    """The texts of all CMake files of the package, without comments."""
    for pattern in ("**/CMakeLists.txt", "**/*.cmake"):
        for path in glob.glob(pattern, root_dir=package.folder, recursive=True):
            with contextlib.suppress(SourceError):
                text = PackageText(package.file(path), errors="replace").text
                yield re.sub(r"#.*", "", text)


def _module_folders(text: str) -> list[str]:
    """What a file adds to the places of modules."""
    words = (word.strip('"') for found in _MODULES.findall(text) for word in found.split())
    return [one for one in words if one not in _WORDS]
