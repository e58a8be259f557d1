"""The packages of a workspace, found and ordered as by colcon."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from launcher.base import text_file
from launcher.workspace.building.sources import manifest
from launcher.workspace.building.sources.manifest import Dependency, Manifest
from launcher.workspace.building.sources.source_text import PackageText, SourceError, shown

_IGNORE = ("COLCON_IGNORE", "AMENT_IGNORE", "CATKIN_IGNORE")
_PROJECT = re.compile(r"^\s*project\s*\(\s*\"?([\w.-]+)", re.IGNORECASE | re.MULTILINE)
_WITHOUT_LANGUAGE = re.compile(r"^\s*project\s*\([^)]*\sNONE\s*\)", re.IGNORECASE | re.MULTILINE)
_MORE_LANGUAGES = re.compile(r"\b(add_subdirectory|enable_language|include)\s*\(", re.IGNORECASE)
_NAME = re.compile(r"<name>\s*([\w-]+)")
_FIND = re.compile(r"\bfind_package\s*\(\s*\"?([\w-]+)", re.IGNORECASE)


@dataclass(frozen=True)
class Package:
    """A package's source folder.

    `build_type` is that of package.xml (`ament_cmake`, `ament_python`, `cmake`, ...), or `cmake`
    and `python` for folders without package.xml, which have no `manifest`.
    """

    name: str
    folder: str
    build_type: str
    manifest: Manifest | None = None
    dependencies: tuple[Dependency, ...] = ()

    @property
    def is_python(self) -> bool:
        return self.build_type in ("ament_python", "python")

    @property
    def is_compiled(self) -> bool:
        """Whether it may need a compiler: not if `project()` says that it has no language."""
        text = self._cmake_text
        is_plain = _WITHOUT_LANGUAGE.search(text) and not _MORE_LANGUAGES.search(text)
        return not self.is_python and not is_plain

    @property
    def has_interfaces(self) -> bool:
        """Whether interfaces are generated, for which the header files of Python are needed."""
        return not self.is_python and "rosidl_generate_interfaces" in self._cmake_text

    @property
    def _cmake_text(self) -> str:
        return _cmake_text(self.folder, "CMakeLists.txt") if self.has("CMakeLists.txt") else ""

    def file(self, *names: str) -> str:
        """The path of a file of the package."""
        return os.path.join(self.folder, *names)

    def has(self, *names: str) -> bool:
        return os.path.isfile(self.file(*names))


@dataclass
class FoundPackages:
    """The packages below some folders, and the errors of those that cannot be read.

    Of `unreadable` packages only the folders are known, and the names as far as they can be read.
    """

    packages: list[Package] = field(default_factory=list)
    errors: list[SourceError] = field(default_factory=list)
    unreadable: list[Package] = field(default_factory=list)

    @property
    def everything(self) -> list[Package]:
        return [*self.unreadable, *self.packages]


def find(folders: Iterable[str], env: Mapping[str, str] = os.environ) -> FoundPackages:
    """All packages in and below the folders, sorted by name; raises nothing.

    Like colcon it follows links, does not look below a package, and leaves out hidden folders and
    those with a file COLCON_IGNORE, AMENT_IGNORE or CATKIN_IGNORE. `env` has the variables of
    conditions in package.xml.
    """
    found = FoundPackages()
    for folder in package_folders(folders):
        try:
            package = read(folder, env)
        except SourceError as error:
            error.package = error.package or _name_in_broken(folder)
            found.errors.append(error)
            found.unreadable.append(Package(error.package, folder, ""))
            continue
        if package is not None:
            found.packages.append(package)
    found.packages.sort(key=lambda package: (package.name, package.folder))
    found.errors += _duplicates(found.packages)
    return found


def package_folders(folders: Iterable[str]) -> Iterator[str]:
    """The folders of packages in and below some folders, each once."""
    seen: set[str] = set()
    for base in folders:
        for folder, below, files in os.walk(base, followlinks=True):
            real = os.path.realpath(folder)
            if real in seen or any(name in files for name in _IGNORE):
                below.clear()
                continue
            seen.add(real)
            if _is_package(folder, files):
                yield folder
                below.clear()
                continue
            below[:] = sorted(name for name in below if not name.startswith("."))


def _is_package(folder: str, files: Sequence[str]) -> bool:
    if "package.xml" in files or "setup.py" in files:
        return True
    return "CMakeLists.txt" in files and not _is_catkin_toplevel(folder)


def _is_catkin_toplevel(folder: str) -> bool:
    """Whether it is the `src/` of a workspace of ROS 1, which has a CMakeLists.txt."""
    path = os.path.join(folder, "CMakeLists.txt")
    try:
        return "catkin_workspace()" in text_file.read(path, errors="replace").splitlines()
    except OSError:
        return False


def read(folder: str, env: Mapping[str, str] = os.environ) -> Package | None:
    """The package in a folder; None if there is none. SourceError if package.xml is wrong."""
    path = os.path.join(folder, "package.xml")
    if os.path.lexists(path):
        xml = manifest.read(path, env)
        return Package(xml.name, folder, xml.build_type, xml, xml.dependencies)
    folder_name = os.path.basename(os.path.abspath(folder))
    if os.path.isfile(os.path.join(folder, "CMakeLists.txt")):
        project = _PROJECT.search(_cmake_text(folder, "CMakeLists.txt"))
        name = project[1] if project else folder_name
        return Package(name, folder, "cmake", dependencies=_looked_for(folder))
    if os.path.isfile(os.path.join(folder, "setup.py")):
        return Package(python_name(folder) or folder_name, folder, "python")
    return None


def _name_in_broken(folder: str) -> str:
    """The name in a package.xml that cannot be parsed, else that of the folder."""
    with contextlib.suppress(SourceError):
        text = PackageText(os.path.join(folder, "package.xml"), errors="replace").text
        if match := _NAME.search(text):
            return match[1]
    return os.path.basename(os.path.abspath(folder))


def _looked_for(folder: str) -> tuple[Dependency, ...]:
    """What the CMake files of a package without package.xml look for, which colcon builds first."""
    names: dict[str, None] = {}
    for below, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for file in sorted(files):
            if file == "CMakeLists.txt" or file.endswith(".cmake"):
                with contextlib.suppress(SourceError):
                    names |= dict.fromkeys(_FIND.findall(_cmake_text(below, file)))
    return tuple(Dependency(name, "find_package", ("build", "run"), 0) for name in names)


def _cmake_text(folder: str, file: str) -> str:
    """The text of a file without its comments."""
    return re.sub(r"#.*", "", PackageText(os.path.join(folder, file), errors="replace").text)


def python_name(folder: str) -> str | None:
    """The name in setup.cfg, or in the call of `setup` in setup.py if it is written there."""
    from launcher.workspace.building.sources.setup_file import SetupFile, configured_name

    name = configured_name(os.path.join(folder, "setup.cfg"))
    if name is not None:
        return name
    try:
        setup = SetupFile(os.path.join(folder, "setup.py"))
    except SourceError:
        return None
    value = setup.text("name")
    return value and value[0]


def _duplicates(packages: Sequence[Package]) -> Iterator[SourceError]:
    """Packages of one name, whose build and install folders would be the same."""
    first: dict[str, Package] = {}
    for package in packages:
        other = first.setdefault(package.name, package)
        if other is package:
            continue
        hint = (
            f"rename one of them, or keep one out of the build with an empty file "
            f"{shown(package.file('COLCON_IGNORE'))}"
        )
        message = (
            f"two packages are called '{package.name}', the other one is {shown(other.folder)}"
        )
        if package.manifest is not None:
            source, line = package.manifest.source, package.manifest.name_line
            error = source.error(message, line, at=package.name, hint=hint)
        else:
            error = SourceError(message, where=shown(package.folder), hint=hint)
        error.package = package.name
        yield error


# ---- order


def dependencies_within(packages: Sequence[Package], *kinds: str) -> dict[str, set[str]]:
    """Package -> packages of the workspace that it names as dependencies, of all kinds by default.

    A dependency on a group is one on all packages that are members of it.
    """
    names = {package.name for package in packages}
    members: dict[str, set[str]] = {}
    for package in packages:
        for group in package.manifest.groups if package.manifest else ():
            members.setdefault(group, set()).add(package.name)
    needed: dict[str, set[str]] = {}
    for package in packages:
        direct = {one.name for one in package.dependencies if not kinds or {*kinds} & {*one.kinds}}
        for group, _ in package.manifest.group_dependencies if package.manifest else ():
            direct |= members.get(group, set())
        needed[package.name] = (direct & names) - {package.name}
    return needed


def in_order(packages: Sequence[Package]) -> list[Package]:
    """The packages, dependencies first, else by name; SourceError for a dependency cycle.

    Like colcon it considers all kinds of dependencies, those of tests included.
    """
    for error in cycles(packages):
        raise error
    needed = dependencies_within(packages)
    left = {package.name: package for package in packages}
    ordered: list[Package] = []
    while left:
        ready = sorted(name for name in left if not needed[name] & left.keys())
        ordered += [left.pop(name) for name in ready]
    return ordered


def with_dependencies(packages: Sequence[Package], names: Iterable[str], *kinds: str) -> set[str]:
    """The names and all packages of the workspace that they need, by all kinds by default."""
    needed = dependencies_within(packages, *kinds)
    found: set[str] = set()
    level = {*names} & needed.keys()
    while level:
        found |= level
        level = {below for name in level for below in needed[name]} - found
    return found


def with_dependents(packages: Sequence[Package], names: Iterable[str], *kinds: str) -> set[str]:
    """The names and all packages of the workspace that need them, by all kinds by default."""
    needed = dependencies_within(packages, *kinds)
    found = {*names}
    while more := {name for name, below in needed.items() if below & found} - found:
        found |= more
    return found


def cycles(packages: Sequence[Package]) -> list[SourceError]:
    """An error for each dependency cycle: `a -> b -> a`, at the line that names `b`."""
    needed = dependencies_within(packages)
    by_name = {package.name: package for package in packages}
    errors, done = [], set[str]()
    for name in sorted(needed):
        path = None if name in done else path_back(name, needed)
        if path is None:
            continue
        done.update(path)
        error = _cycle_error(by_name[name], path)
        error.package = name
        errors.append(error)
    return errors


def in_cycles(packages: Sequence[Package]) -> set[str]:
    """The packages that need themselves, over others."""
    needed = dependencies_within(packages)
    return {name for name in needed if path_back(name, needed) is not None}


def path_back(start: str, needed: Mapping[str, set[str]]) -> list[str] | None:
    """The shortest way from a name over those that it needs to itself."""
    level = [[start]]
    seen: set[str] = set()
    while level:
        longer = []
        for path in level:
            for name in sorted(needed[path[-1]]):
                if name == start:
                    return [*path, start]
                if name not in seen:
                    seen.add(name)
                    longer.append([*path, name])
        level = longer
    return None


def _cycle_error(package: Package, path: Sequence[str]) -> SourceError:
    message = f"dependency cycle: {' -> '.join(path)}"
    hint = "remove one of these dependencies, or move what both need into a separate package"
    if package.manifest is None:
        return SourceError(message, where=shown(package.folder), hint=hint)
    line = next((one.line for one in package.dependencies if one.name == path[1]), None)
    line = line or next(iter(line for _, line in package.manifest.group_dependencies), None)
    return package.manifest.source.error(message, line, at=path[1], hint=hint)
