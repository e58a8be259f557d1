"""Which distributions a wheel requires, and in which versions."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from importlib import metadata

from launcher.packages.source_packages import MARKERS
from launcher.packages.workspace import find as find_workspace
from launcher.workspace.building.sources import Package

# In RECORD, whose paths are relative to site-packages.
_PACKAGE = re.compile(r"/share/ament_index/resource_index/packages/([^/,\"]+)")
_LIBRARY = re.compile(r"^\"?(?:\.\./)+(?:lib/)?(lib[^/,\"]+\.so[.\d]*)[,\"]", re.MULTILINE)

_LAUNCHER = {"launch", "launch_ros", "launch_xml", "launch_yaml", "ros2launch"}  # it has them


@dataclass
class Installed:
    """The distributions of this environment: ROS package or library -> name and version."""

    packages: dict[str, tuple[str, str]] = field(default_factory=dict)
    libraries: dict[str, tuple[str, str]] = field(default_factory=dict)


def installed() -> Installed:
    found = Installed()
    for distribution in metadata.distributions():
        record = distribution.read_text("RECORD") or ""
        owner = (distribution.metadata["Name"], distribution.version)
        for name in _PACKAGE.findall(record):
            found.packages.setdefault(name, owner)
        for name in _LIBRARY.findall(record):
            found.libraries.setdefault(name, owner)
    return found


@dataclass(frozen=True)
class Requirements:
    """`words` are those of Requires-Dist. `unknown` are names in package.xml that neither the
    workspace nor this environment has, such as those of system packages.
    """

    words: tuple[str, ...]
    unknown: tuple[str, ...]


def of_package(
    package: Package,
    workspace: Mapping[str, Package],
    environment: Installed,
    libraries: Collection[str] | None,
) -> Requirements:
    """What a package needs at run time.

    `libraries` are those that its own need, None if it has none. They contain the structures of
    messages of other packages, which must be the very version. Those of ROS stay the same while the
    first two numbers of a version do, and so its wheels require each other.
    """
    relation = ">=" if libraries is None else "=="
    words, unknown = set(), []
    named = package.manifest.names("run") if package.manifest else set()
    if package.manifest and "rosidl_interface_packages" in package.manifest.groups:
        named |= {"rosidl_default_runtime"} & environment.packages.keys()
    for name in sorted(named):
        other = workspace.get(name)
        if other is not None:
            words.add(f"{name}{relation}{version_of(other)}")
        elif name in environment.packages:
            words.add(_bounded(*environment.packages[name], relation))
        elif name not in _LAUNCHER:
            unknown.append(name)
    owners = {environment.libraries[one] for one in libraries or () if one in environment.libraries}
    words |= {_bounded(*owner, relation) for owner in owners}
    return Requirements(tuple(sorted(words)), tuple(unknown))


def in_workspaces(names: Iterable[str], environ: Mapping[str, str]) -> dict[str, list[str]]:
    """Those of the packages that other workspaces have installed, by the roots of these."""
    prefixes = [*filter(None, environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep))]
    found: dict[str, list[str]] = {}
    for name in names:
        markers = (os.path.join(prefix, MARKERS, name) for prefix in prefixes)
        marker = next(filter(os.path.isfile, markers), None)
        workspace = find_workspace(os.path.dirname(marker)) if marker else None
        if workspace is not None:
            found.setdefault(workspace.root, []).append(name)
    return found


def merged(words: Iterable[str], more: Iterable[str]) -> tuple[str, ...]:
    """The requirements, and those of others for distributions that they do not name."""
    words = tuple(words)
    names = {_name(one) for one in words}
    return tuple(sorted({*words, *(one for one in more if _name(one) not in names)}))


def version_of(package: Package) -> str:
    return package.manifest.version if package.manifest else "0.0.0"


def _bounded(name: str, version: str, relation: str) -> str:
    if name.startswith("ros-") and "." in version:
        relation = "~="
    return f"{name}{relation}{version}"


def _name(requirement: str) -> str:
    return re.sub(r"[-_.]+", "-", re.split(r"[^\w.-]", requirement.strip(), maxsplit=1)[0]).lower()
