"""Which installed files of a package a wheel has, and where pip puts them."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass

from launcher.base.errors import LauncherError
from launcher.base.program import program
from launcher.workspace.building.build_place import Place
from launcher.workspace.building.sources import Package
from launcher.workspace.building.sources.source_text import shown
from launcher.workspace.building.wheel.archive import WheelEntry

_MANIFESTS = ("install_manifest.txt", "symlink_install_manifest.txt")
_PYTHON = re.compile(r"(?:local/)?lib/python(\d+\.\d+)/(?:site|dist)-packages/")
# Scripts that set variables for a separate prefix; in that of Python nothing needs them, and they
# name the folder of the workspace.
_SCRIPTS = re.compile(
    r"share/[^/]+/(?:environment/.*|hook/.*|(?:local_setup|package)\.(?:bash|dsv|ps1|sh|zsh))"
    r"|share/(?:colcon-core|ament_index/resource_index/parent_prefix_path)/.*"
)
_USUAL_HOOKS = {"ament_prefix_path", "library_path", "path", "pythonpath"}
# Installed as links they have the mode of the compiler, as copies that of CMake.
_LIBRARY = re.compile(r"\.so(?:\.\d+)*$")
_LEGAL = re.compile(r"(?:licen[cs]e|copying|notice|authors)[^/]*", re.IGNORECASE)


@dataclass(frozen=True)
class WheelContents:
    """The files of a wheel, but for the folder that describes it.

    `python` is the version that extension modules are for, "3.11"; None if there are none.
    `modules` go to site-packages, `data` to the prefix. `entry_points` is the text of that file.
    """

    modules: tuple[WheelEntry, ...]
    data: tuple[WheelEntry, ...]
    python: str | None = None
    entry_points: str = ""
    left_out: tuple[str, ...] = ()


def prefix_of(place: Place, name: str) -> str:
    return place.install if place.is_merged else os.path.join(place.install, name)


def is_built(place: Place, name: str) -> bool:
    """Whether the package is in `install/`, by the ament index or by colcon's."""
    share = os.path.join(prefix_of(place, name), "share")
    markers = ("ament_index/resource_index/packages", "colcon-core/packages")
    return any(os.path.isfile(os.path.join(share, marker, name)) for marker in markers)


def installed(place: Place, package: Package) -> WheelContents:
    """The files that CMake has installed; LauncherError."""
    prefix = prefix_of(place, package.name)
    names = _installed_names(place, package, prefix)
    groups = package.manifest.groups if package.manifest else ()
    is_interface = "rosidl_interface_packages" in groups
    modules, data = [], []
    python = None
    for name in names:
        if _SCRIPTS.fullmatch(name) or "__pycache__/" in name:
            continue
        if is_interface and name.endswith(".c"):
            continue  # generated, and compiled into the libraries
        path = os.path.join(prefix, name)
        is_executable = os.access(path, os.X_OK) and _LIBRARY.search(name) is None
        in_python = _PYTHON.match(name)
        if in_python is None:
            data.append(WheelEntry(name, path, is_executable))
        elif ".egg-info/" not in name:  # the metadata of the wheel take its place
            modules.append(WheelEntry(name[in_python.end() :], path, is_executable))
            python = in_python[1] if name.endswith(".so") else python
    return WheelContents(
        tuple(modules), tuple(data), python, _entry_points(prefix, names), _own_hooks(names)
    )


def _entry_points(prefix: str, names: Sequence[str]) -> str:
    path = next((name for name in names if name.endswith(".egg-info/entry_points.txt")), None)
    if path is None:
        return ""
    with open(os.path.join(prefix, path), encoding="utf-8") as file:
        return file.read()


def _own_hooks(names: Sequence[str]) -> tuple[str, ...]:
    """Scripts of the package that set further variables."""
    hooks = (name for name in names if "/environment/" in name and _SCRIPTS.fullmatch(name))
    return tuple(
        name for name in hooks if os.path.splitext(os.path.basename(name))[0] not in _USUAL_HOOKS
    )


def _installed_names(place: Place, package: Package, prefix: str) -> list[str]:
    """The files that CMake lists, relative to the prefix.

    The prefix may have more: what another version of the package has installed, and what Python and
    colcon have written.
    """
    listed: set[str] = set()
    for manifest in _MANIFESTS:
        try:
            with open(os.path.join(place.build, package.name, manifest), encoding="utf-8") as file:
                listed.update(line for line in file.read().splitlines() if line)
        except FileNotFoundError:
            continue
    names = {os.path.relpath(path, prefix) for path in listed}
    wrong = [one for one in names if one.startswith("..")]
    missing = [one for one in names if not os.path.isfile(os.path.join(prefix, one))]
    if not names or wrong or missing:
        reason = (
            f"{shown(os.path.join(place.build, package.name))} does not list what is installed"
            if not names
            else "the workspace was moved after the build"
            if wrong
            else f"{shown(os.path.join(prefix, min(missing)))} is missing"
        )
        raise LauncherError(
            f"{package.name}: {reason}",
            hint=f"build it again: {program()} build --all {shown(package.folder)}",
        )
    return sorted(names)


def legal_files(package: Package) -> list[WheelEntry]:
    """LICENSE and the like in the top folder of the sources."""
    return [
        WheelEntry(name, package.file(name))
        for name in sorted(os.listdir(package.folder))
        if _LEGAL.fullmatch(name) and os.path.isfile(package.file(name))
    ]
