"""What is stale in a workspace: facts for the checks."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from launcher.base.errors import LauncherError
from launcher.base.program import program
from launcher.doctor.doctor_facts import WorkspaceFacts
from launcher.packages.activation import built_elsewhere, dead_link
from launcher.packages.environment import of_build, read, underlays
from launcher.packages.environment import packages as installed_packages
from launcher.packages.finder import search_prefixes
from launcher.packages.source_packages import MARKERS, name_in
from launcher.packages.workspace import Workspace
from launcher.workspace.building import records, sources
from launcher.workspace.building.build_place import Place
from launcher.workspace.building.sources import Package
from launcher.workspace.building.toolchain import build_variables
from launcher.workspace.building.toolchain import versions as tools

_PYTHON = f"python{sys.version_info.major}.{sys.version_info.minor}"


def inspect(workspace: Workspace, environ: Mapping[str, str]) -> WorkspaceFacts:
    """The facts about a workspace; `environ` is the environment without it."""
    base = os.path.join(workspace.root, "src")
    place = Place(workspace.root, base)
    found = [_package(folder) for folder in sources.package_folders([base])]
    try:
        scripts = read(workspace).scripts
        installed = installed_packages(workspace.install)
        below = underlays(workspace)
        moved_from = built_elsewhere(workspace)
        used = build_variables.prefixes(of_build(workspace, environ), place)
    except LauncherError as error:
        text = f"{error.where}: {error.message}" if error.where else error.message
        return WorkspaceFacts(root=workspace.root, build=_command(workspace), error=text)
    # Of another folder than `install`, the build folder is not known.
    is_usual = workspace.install == place.install
    known = {name: record for name in installed if (record := records.read(place, name))}
    known = known if is_usual else {}
    names = {package.name for package in found}
    gone = [name for name in installed if name not in names and (found or _was_here(place, name))]
    dead = {name: link for name in installed if (link := dead_link(installed[name], name))}
    return WorkspaceFacts(
        root=workspace.root,
        build=_command(workspace),
        is_merged=place.is_merged,
        scripts=tuple(scripts),
        missing_underlays=tuple(path for path in below if not os.path.isdir(path)),
        changed=_changed(place, found, installed, known, used) if is_usual else {},
        cleaned=tuple(known),
        moved_from=moved_from,
        broken={
            name: folder
            for name in dead
            if name in names and not os.path.isdir(folder := os.path.join(place.build, name))
        },
        gone=tuple(gone),
        dead=tuple(name for name in gone if name in dead),
        other_python={**dict(_recorded_python(known)), **dict(_of_other_python(installed))},
        no_interpreter=dict(_without_interpreter(installed)),
        twice=_twice(found),
        hides=_hidden(installed, workspace.install, environ),
    )


def _package(folder: str) -> Package:
    """The package in a folder, without the checks of a build, which need the extra of that."""
    name = name_in(folder) or os.path.basename(folder)
    is_cmake = os.path.isfile(os.path.join(folder, "CMakeLists.txt"))
    return Package(name, folder, "ament_cmake" if is_cmake else "ament_python")


def _command(workspace: Workspace) -> str:
    """The command that builds it, from the working directory."""
    is_here = f"{os.getcwd()}/".startswith(f"{workspace.root}/")
    return f"{program()} build" + ("" if is_here else f" {shlex.quote(workspace.root)}")


# ---- sources and builds


def _changed(
    place: Place,
    found: Sequence[Package],
    installed: Mapping[str, str],
    known: Mapping[str, dict[str, Any]],
    prefixes: Sequence[str],
) -> dict[str, str]:
    """Package -> why it must be built."""
    used, interfaces = tools.fingerprint(), tools.interfaces(prefixes)
    names = {package.name for package in found}
    reasons = {}
    for package in found:
        record = known.get(package.name)
        if package.name not in installed:
            reasons[package.name] = "not built"
        elif record is None:
            newer = _newer_source(place, package)
            if newer is not None:
                reasons[package.name] = f"{newer} changed"
        else:
            lost = sorted(record["dependencies"].keys() - names)
            reason = f"{lost[0]}, which it depends on, is gone from src/" if lost else None
            reason = reason or _since(place, package, record, used, prefixes)
            if reason is None and record["setting"].get("interfaces", interfaces) != interfaces:
                reason = "messages of a workspace below have changed"
            if reason is not None:
                reasons[package.name] = reason
    return reasons


def _since(
    place: Place, package: Package, last: dict[str, Any], used: str, prefixes: Sequence[str]
) -> str | None:
    """What differs from the record of the last build; the compiler and options are left aside."""
    before: str = last["setting"]["tools"]
    python = before.rpartition(" ")[0]
    if python != used.rpartition(" ")[0]:
        return f"built with Python {python.replace(' ', ' of ', 1)}"
    changes = records.source_changes(package, last, place)
    if changes:
        return changes[0]
    if before != used:
        return "wheels were updated, installed or removed since it was built"
    return _other_prefixes(last["setting"].get("prefixes", prefixes), prefixes)


def _other_prefixes(before: Sequence[str], now: Sequence[str]) -> str | None:
    """What differs in the prefixes that a package was built on, and is built on now."""
    if [*before] == [*now]:
        return None
    for lost in _topmost(before):
        if lost not in now:
            is_there = os.path.isdir(lost)
            return f"built on {lost}, which " + ("is not in use now" if is_there else "is gone")
    for new in _topmost(now):
        if new not in before:
            return f"built without {new}, which is in use now"
    return "built on the same workspaces with other packages, or in another order"


def _topmost(prefixes: Sequence[str]) -> list[str]:
    """The prefixes without those of single packages in a workspace."""
    return [path for path in prefixes if not any(path.startswith(f"{each}/") for each in prefixes)]


def _was_here(place: Place, name: str) -> bool:
    """Whether a package was built in this workspace, and not only installed into it."""
    return os.path.isdir(place.base) or os.path.isdir(os.path.join(place.build, name))


def _newer_source(place: Place, package: Package) -> str | None:
    """A file that is newer than the build by plain colcon; those that are only linked do not count.

    None also if it cannot be determined, since the build folder is gone.
    """
    build = os.path.join(place.build, package.name)
    try:
        built_ns = os.stat(os.path.join(build, "colcon_build.rc")).st_mtime_ns
    except OSError:
        return None
    hook = os.path.join("share", package.name, "hook", "pythonpath_develop.dsv")
    links = os.path.isfile(os.path.join(build, hook)) or _links_files(build)
    setting = records.BuildSetting(place, links, "", "", ())
    files = records.make(package, setting, {}, None)["files"]
    newer = [name for name, (time_ns, *_) in files.items() if time_ns > built_ns]
    return min(newer, default=None)


def _links_files(build: str) -> bool:
    """Whether a package of CMake was built with --symlink-install."""
    return os.path.isfile(os.path.join(build, "ament_cmake_symlink_install_manifest.txt")) or (
        os.path.isdir(os.path.join(build, "ament_cmake_symlink_install"))
    )


# ---- what is installed


def _recorded_python(known: Mapping[str, dict[str, Any]]) -> Iterator[tuple[str, str]]:
    """(package, version) for a package that was built by another Python version."""
    for name, record in known.items():
        version = ".".join(record["setting"]["tools"].split(".")[:2])
        if f"python{version}" != _PYTHON:
            yield name, version


def _of_other_python(installed: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """(package, version) for a package that has its modules only for another Python."""
    for name, prefix in installed.items():
        lib = os.path.join(prefix, "lib")
        versions = [each for each in _entries(lib) if each.startswith("python3.")]
        # In a merged prefix, the folders are those of all packages.
        having = [each for each in versions if _has_modules(os.path.join(lib, each), name)]
        if having and _PYTHON not in having:
            yield name, having[0].removeprefix("python")


def _has_modules(folder: str, package: str) -> bool:
    site = os.path.join(folder, "site-packages")
    link = f"{package.replace('_', '-')}.egg-link"
    return any(each == link or each.partition("-")[0] == package for each in _entries(site))


def _without_interpreter(installed: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """(package, interpreter) where a program begins with `#!` and a path that does not exist."""
    for name, prefix in installed.items():
        libexec = os.path.join(prefix, "lib", name)
        for program_name in _entries(libexec):
            interpreter = _interpreter(os.path.join(libexec, program_name))
            if interpreter is not None and not os.path.exists(interpreter):
                yield name, interpreter
                break


def _interpreter(file: str) -> str | None:
    try:
        with open(file, "rb") as opened:
            line = opened.readline(4096)
    except OSError:
        return None
    words = os.fsdecode(line[2:]).split() if line.startswith(b"#!") else []
    return words[0] if words else None


def _twice(found: Sequence[Package]) -> dict[str, tuple[str, ...]]:
    folders: dict[str, tuple[str, ...]] = {}
    for package in found:
        folders[package.name] = (*folders.get(package.name, ()), package.folder)
    return {name: paths for name, paths in folders.items() if len(paths) > 1}


def _hidden(
    installed: Mapping[str, str], install: str, environ: Mapping[str, str]
) -> dict[str, str]:
    """Package -> the prefix outside of the workspace that has it as well."""
    prefixes = [str(path) for path in search_prefixes(environ)]
    others = [path for path in prefixes if not f"{path}/".startswith(f"{install}/")]
    return {
        name: prefix
        for name in installed
        for prefix in reversed(others)
        if os.path.isfile(os.path.join(prefix, MARKERS, name))
    }


def _entries(folder: str) -> list[str]:
    try:
        return sorted(os.listdir(folder))
    except OSError:
        return []
