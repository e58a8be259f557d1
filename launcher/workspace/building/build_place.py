"""The workspace that a build works in, and which of its packages were named."""

from __future__ import annotations

import contextlib
import errno
import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from launcher.base.errors import LauncherError, UsageError
from launcher.base.program import program
from launcher.base.text import shown_path
from launcher.packages.unbuilt import way_to
from launcher.packages.workspace import MARKER, VARIABLE, absolute, is_install
from launcher.workspace.building import sources

_BAD_CHARACTERS = {
    ":": "search paths such as PYTHONPATH separate by it",
    ";": "lists of CMake separate by it",
    '"': "strings of CMake end with it",
    "\\": "it begins an escape sequence of CMake",
}
_CONTROL_CHARACTER = "CMake and make cannot take control characters in paths"


@dataclass(frozen=True)
class Place:
    """A workspace: `root` holds `build/`, `install/` and `log/`; `base` holds the packages.

    A package outside of a workspace is itself a workspace, as for colcon: then both are its folder.
    `named` are the folders of packages that the command line names; empty means all.
    """

    root: str
    base: str
    named: tuple[str, ...] = ()

    @property
    def build(self) -> str:
        return os.path.join(self.root, "build")

    @property
    def install(self) -> str:
        return os.path.join(self.root, "install")

    @property
    def log(self) -> str:
        return os.path.join(self.root, "log")

    @property
    def is_merged(self) -> bool:
        """Whether all packages share the prefix `install/`: built by colcon's --merge-install."""
        try:
            with open(os.path.join(self.install, MARKER), encoding="utf-8") as file:
                return file.read().strip() == "merged"
        except OSError:
            return False


_ROOM_BYTES = 64 * 1024
FULL_DISK_HINT = "make space and repeat the command: what is built already is kept"
_READ_ONLY_HINT = (
    "is it read-only, or of another user? ls -ld shows its owner, sudo chown -R changes it"
)


def not_written(path: str, error: OSError) -> LauncherError:
    """The error for a file in `build/` that cannot be written."""
    is_full = error.errno in (errno.ENOSPC, errno.EDQUOT)
    return LauncherError(
        f"cannot write to {path}: {error.strerror}",
        hint=FULL_DISK_HINT if is_full else _READ_ONLY_HINT,
    )


def require_writable(place: Place) -> None:
    """LauncherError if a folder of the build cannot be written."""
    for folder in (place.build, place.install, place.log):
        existing = folder if os.path.lexists(folder) else place.root
        if not os.path.isdir(existing):
            raise LauncherError(f"{existing} is not a folder", hint="move it elsewhere")
        if not os.access(existing, os.W_OK | os.X_OK):
            raise LauncherError(f"cannot write to {existing}", hint=_READ_ONLY_HINT)


def full_folders(place: Place) -> list[str]:
    """The folders of the build whose file system is full."""
    full = []
    for folder in (place.build, place.install, place.log, tempfile.gettempdir()):
        with contextlib.suppress(OSError):
            if os.statvfs(folder).f_bavail * os.statvfs(folder).f_frsize < _ROOM_BYTES:
                full.append(folder)
    return full


def find(paths: Sequence[str]) -> Place:
    """The workspace of some paths in it; UsageError.

    Without a path, that of --workspace, or of the working directory.
    """
    chosen = os.path.expanduser(os.environ.get(VARIABLE) or ".")
    found = [_real(_of(path)) for path in paths or [chosen]]
    root, base = found[0].root, found[0].base
    for path, place in zip(paths, found, strict=False):
        if place.root != root:
            raise UsageError(
                f"{shown_path(path)} is in another workspace than {shown_path(paths[0])}",
                hint="build them one after the other",
            )
    _check_characters(root)
    named = [folder for place in found for folder in place.named]
    is_all = any(not place.named for place in found)
    return Place(root, base, () if is_all else tuple(dict.fromkeys(named)))


def unbuilt() -> Place | None:
    """The workspace that the working directory is in, if it has packages but no `install/`."""
    try:
        found = find([]) if VARIABLE not in os.environ else None
    except LauncherError:
        return None
    if found is None or found.base == found.root or is_install(found.install):
        return None
    return found


def _real(place: Place) -> Place:
    """In the real folder of the workspace: by a link to it, the builds would look moved."""
    root = os.path.realpath(place.root)
    return replace(place, root=root, base=root if place.base == place.root else f"{root}/src")


def _of(path: str) -> Place:
    start = absolute(path)
    if not os.path.isdir(start):
        problem = "is not a folder" if os.path.exists(start) else "does not exist"
        raise UsageError(
            f"{shown_path(path)} {problem}",
            hint="name a workspace, a folder in it, or a package's folder; packages by their name "
            f"go behind --packages-select: {program()} build -- --packages-select NAME",
        )
    package = None
    for folder in [start, *map(str, Path(start).parents)]:
        if _is_package(folder):
            package = folder
        elif _is_src(folder, package):
            return _in_workspace(os.path.dirname(folder), start, package)
        elif folder != start and not is_install(os.path.join(folder, "install")):
            continue
        elif _has_packages(os.path.join(folder, "src")):
            return _in_workspace(folder, start, package)
    if package is not None:
        return Place(package, package)
    if is_install(os.path.join(start, "install")):
        raise UsageError(
            f"the workspace {shown_path(start)} has no packages in src/ any more",
            hint="put them back; what is in install/ can be used without them, unless it is linked",
        )
    raise UsageError(
        f"no workspace at {shown_path(start)} or above it",
        hint=_one_below(start)
        or "a workspace is a folder with packages in src/; a package has a package.xml",
    )


def _one_below(folder: str) -> str | None:
    """The hint that names a workspace directly below a folder."""
    try:
        names = sorted(name for name in os.listdir(folder) if not name.startswith("."))
    except OSError:
        return None
    roots = (os.path.join(folder, name) for name in names)
    found = (root for root in roots if _has_packages(os.path.join(root, "src")))
    root = next(found, None)
    return root and f"there is one in {way_to(root)}"


def _in_workspace(root: str, start: str, package: str | None) -> Place:
    base = os.path.join(root, "src")
    if package is not None:
        return Place(root, base, (package,))
    below = tuple(sources.package_folders([start])) if _is_below(start, base) else ()
    if start != base and _is_below(start, base) and not below:
        raise UsageError(f"no package in {shown_path(start)}", hint="a package has a package.xml")
    if not _has_packages(base):
        raise UsageError(
            f"no package in {shown_path(base)}",
            hint=f"a package is a folder with a package.xml; {program()} pkg create NAME makes one",
        )
    return Place(root, base, () if start == base else below)


def _check_characters(root: str) -> None:
    """UsageError for a path with what has another meaning in lists, search paths and CMake."""
    bad = next((one for one in root if one in _BAD_CHARACTERS or one < " "), None)
    if bad is not None:
        raise UsageError(
            f"a workspace cannot be built in a folder with {bad!r} in its path: {root}",
            hint=f"rename or move it: {_BAD_CHARACTERS.get(bad, _CONTROL_CHARACTER)}",
        )


def _is_below(path: str, folder: str) -> bool:
    return path == folder or path.startswith(folder.rstrip("/") + "/")


def _is_src(folder: str, package: str | None) -> bool:
    """Whether it is the `src` of a workspace, and not where all sources of the user are."""
    root = os.path.dirname(folder)
    if os.path.basename(folder) != "src" or _is_package(root):
        return False
    is_shared = package is not None and root in ("/", os.path.expanduser("~"))
    return not is_shared or is_install(os.path.join(root, "install"))


def _is_package(folder: str) -> bool:
    return os.path.isfile(os.path.join(folder, "package.xml"))


def _has_packages(folder: str) -> bool:
    return next(iter(sources.package_folders([folder])), None) is not None
