"""What a package was built from: `build/PACKAGE/launcher.json`, and what has changed since.

It is written before a build, so that the next one finds what a failed or killed one has worked on,
and completed after a successful one. It has

* `files`: each source file with its time stamp, size, and digest; without digest where only the
  name counts, since the file is linked into `install/`, not compiled;
* `setting`: the Python, wheels, prefixes, compiler and options that it was built with, `place` its
  folders;
* `dependencies`: the `digest` of each package of the workspace that it depends on;
* `installed`: the files below `install/`; missing until the build has succeeded.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from launcher.base import strict_json
from launcher.workspace.building.build_place import Place
from launcher.workspace.building.sources import Package

NAME = "launcher.json"
_VERSION = 1
_SKIPPED_FOLDERS = {"__pycache__", ".git", ".hg", ".svn", ".pytest_cache", ".mypy_cache"}
# Files whose content counts, since something is made of them; others are linked.
_MADE_FROM_PYTHON = ("setup.py", "setup.cfg", "pyproject.toml", "package.xml")
_MADE_FROM = (
    *(".msg", ".srv", ".action", ".idl"),
    *(".c", ".cc", ".cpp", ".cxx", ".h", ".hh", ".hpp", ".hxx"),
    *(".in", ".em", ".cmake", "CMakeLists.txt"),
    *_MADE_FROM_PYTHON,
)


@dataclass(frozen=True)
class BuildSetting:
    """What is the same for all packages of a build."""

    place: Place
    links: bool
    tools: str
    compiler: str
    options: tuple[str, ...]
    prefixes: tuple[str, ...] = ()  # that the workspace is built on
    interfaces: str = ""  # what is in them
    variables: Mapping[str, str] = field(default_factory=dict)  # that name the ROS distribution

    def of(self, package: Package) -> dict[str, Any]:
        """The part that a package depends on: a Python package needs no compiler."""
        common = {
            "tools": self.tools,
            "prefixes": [*self.prefixes],
            "options": [*self.options],
            "links": self.links,
            "variables": {**self.variables},
        }
        if package.is_python:
            return common
        return {**common, "compiler": self.compiler, "interfaces": self.interfaces}


def path_of(place: Place, name: str) -> str:
    return os.path.join(place.build, name, NAME)


def read(place: Place, name: str) -> dict[str, Any] | None:
    """The record of a package; None if it was not built, or by another version."""
    try:
        with open(path_of(place, name), encoding="utf-8") as file:
            record = strict_json.loads(file.read())
    except (OSError, ValueError):
        return None
    is_known = isinstance(record, dict) and record.get("version") == _VERSION
    return record if is_known else None


def make(
    package: Package, setting: BuildSetting, digests: Mapping[str, str], last: dict[str, Any] | None
) -> dict[str, Any]:
    """The record of a package as it is now, without `installed`.

    `digests` are those of the packages that it depends on. The last record saves reading files
    whose time stamp and size have not changed.
    """
    known = (last or {}).get("files", {})
    files = {
        name: _file_entry(package.file(name), counts, known.get(name))
        for name, counts in _source_files(package, setting.place, setting.links)
    }
    place = setting.place
    record: dict[str, Any] = {
        "version": _VERSION,
        "package": package.name,
        "type": package.build_type,
        "place": {"source": package.folder, "build": place.build, "install": place.install},
        "setting": setting.of(package),
        "dependencies": dict(digests),
        "files": files,
    }
    content = {name: entry[2] for name, entry in files.items()}
    parts = [package.name, record["setting"], record["dependencies"], content]
    record["digest"] = _digest(strict_json.packed(parts, sort_keys=True).encode())
    return record


def store(place: Place, record: dict[str, Any]) -> None:
    """Store the record of a package, before its build."""
    path = path_of(place, record["package"])
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(f"{path}.new", "w", encoding="utf-8") as file:
        file.write(strict_json.packed(record))
    os.replace(f"{path}.new", path)


def complete(place: Place, record: dict[str, Any]) -> None:
    """Store the record of a package after its build."""
    store(place, {**record, "installed": sorted(_installed(place, record["package"]))})


def changes(last: dict[str, Any] | None, now: dict[str, Any], place: Place) -> list[str]:
    """Why a package must be built, most important first; empty if it need not."""
    if last is None:
        return ["not built"]
    if "installed" not in last:
        return ["the last build is not complete"]
    found = []
    if last["place"] != now["place"]:
        found.append("moved")
    found += [
        f"other {key}" for key, value in now["setting"].items() if last["setting"].get(key) != value
    ]
    old, new = last["files"], now["files"]
    found += [f"{name} is gone" for name in old if name not in new]
    found += [f"{name} is new" for name in new if name not in old]
    found += [f"{name} changed" for name in new if name in old and old[name][2] != new[name][2]]
    if last["dependencies"] != now["dependencies"]:
        below = {**last["dependencies"], **now["dependencies"]}
        found += [
            f"{name} changed"
            for name in below
            if last["dependencies"].get(name) != now["dependencies"].get(name)
        ]
    if not {*last["installed"]} <= {*_installed(place, last["package"])}:
        found.append("installed files are missing")
    return found


def source_changes(package: Package, last: dict[str, Any], place: Place) -> list[str]:
    """What has changed in a package and its installed files since its build, in any setting."""
    setting = BuildSetting(place, last["setting"]["links"], "", "", ())
    now = make(package, setting, last["dependencies"], last)
    return changes(last, {**now, "setting": last["setting"]}, place)


def must_start_afresh(last: dict[str, Any] | None, now: dict[str, Any]) -> bool:
    """Whether what was built and installed must be removed first.

    CMake does not notice other tools, and nothing removes what came from a source that is gone.
    """
    if last is None:
        return False
    differs = any(last[key] != now[key] for key in ("place", "setting", "type"))
    return differs or bool(last["files"].keys() - now["files"].keys())


def _source_files(package: Package, place: Place, links: bool) -> Iterator[tuple[str, bool]]:
    """The files of a package, relative to it, and whether their content counts.

    Links to folders are followed, each folder once, but not to one that the package is in.
    """
    top, seen = os.path.realpath(package.folder), set[str]()
    skipped = {place.build, place.install, place.log}  # below the package if it stands alone
    if links and package.is_python:  # its tests are run where they are
        skipped |= {package.file("test"), package.file("tests")}
    for folder, below, names in os.walk(package.folder, followlinks=True):
        real = os.path.realpath(folder)
        if real in seen or top.startswith(f"{real}{os.sep}"):
            below.clear()
            continue
        seen.add(real)
        below[:] = sorted(
            one
            for one in below
            if one not in _SKIPPED_FOLDERS
            and not one.endswith(".egg-info")
            and os.path.join(folder, one) not in skipped
        )
        for name in sorted(names):
            if name.endswith((".pyc", "~", ".swp")):
                continue
            inside = os.path.relpath(os.path.join(folder, name), package.folder)
            made_from = _MADE_FROM_PYTHON if package.is_python else _MADE_FROM
            yield inside, not links or name.endswith(made_from)


def _file_entry(path: str, counts: bool, known: Sequence[Any] | None) -> list[Any]:
    """[time stamp, size, digest]; the digest is empty where the content does not count."""
    try:
        status = os.stat(path)
        if not counts:
            return [0, 0, ""]
        if known and known[:2] == [status.st_mtime_ns, status.st_size] and known[2]:
            return list(known)
        with open(path, "rb") as file:
            return [status.st_mtime_ns, status.st_size, _digest(file.read())]
    except OSError:  # a link to nowhere, or a file that cannot be read: its build fails
        return [0, 0, "unreadable"]


def _installed(place: Place, name: str) -> Iterator[str]:
    """The files of a package below `install/`; links count if they lead somewhere."""
    if place.is_merged:  # a file does not show its package
        return
    prefix = os.path.join(place.install, name)
    for folder, below, names in os.walk(prefix):
        below[:] = [one for one in below if one != "__pycache__"]
        for entry in names:
            path = os.path.join(folder, entry)
            if not entry.endswith(".pyc") and os.path.exists(path):
                yield os.path.relpath(path, prefix)


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:32]
