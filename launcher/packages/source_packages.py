"""Packages that are used from their source folder: installed with `pip install -e`, or not at all.

Python's metadata says where the source of an editable package is (`direct_url.json`, PEP 610).
Packages that are not installed are found by their `package.xml`: in the working directory, above,
below, and beside the package that the working directory is in.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator

from launcher.base import text_file
from launcher.packages import is_reading_once, once

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.packages.dist_info import DistInfo

MARKERS = "share/ament_index/resource_index/packages"
OVERLAY_FOLDER = "launcher-packages-"  # with the user's id, in the temporary directory

_NAME = re.compile(r"<name>\s*([^<\s]+)\s*</name>")
_DEPENDENCY = re.compile(r"<\w*depend\b[^>]*>\s*([^<\s]+)")
_BUILD_FILES = ("package.xml", "setup.py", "setup.cfg", "pyproject.toml", "CMakeLists.txt")
_BUILT = "colcon_build.rc"  # in the build folder of a package
_IGNORED = ("COLCON_IGNORE", "AMENT_IGNORE", "CATKIN_IGNORE", "pyvenv.cfg", _BUILT)
# Not the sources of a package: what tools build, download or write.
_NO_SOURCES = {"build", "install", "log", "node_modules", "__pycache__", "site-packages"}
# The working directory may be a home folder.
_MAX_DEPTH, _MAX_FOLDERS = 4, 1000
_LAUNCHER = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
_OURS = os.path.dirname(_LAUNCHER)
_chosen: dict[str, str] = {}  # package -> source folder
_IN_WHEEL = os.path.join(_LAUNCHER, "demo_package")  # by setup.py of the launcher


def find(name: str) -> str | None:
    """The source of the package: of an editable installation, else around the working directory.

    That in the launcher's wheel is last, and no list has it: it is found only by its name.
    """
    folders = (folder_of(distribution) for distribution in distributions(name))
    folder = next(filter(None, folders), None) or editable().get(name) or _chosen.get(name)
    folder = folder or next((folder for known, folder in around() if known == name), None)
    return folder or (_IN_WHEEL if name == name_in(_IN_WHEEL) else None)


def choose_demo() -> str | None:
    """The package that comes with the launcher: beside it in a clone, else in its wheel.

    From now on it is found before one of its name around the working directory.
    """
    for folder in (_OURS, _IN_WHEEL):
        name = name_in(folder)
        if name:
            _chosen[name] = folder
            return name
    return None


def distributions(name: str | None = None) -> list[DistInfo]:
    """Installed distributions, of this name or all.

    There may be two: an egg-info without files in the source tree, and what is installed from it.
    """
    from launcher.packages.dist_info import installed  # only for packages outside of the index

    return installed(name)


def editable() -> dict[str, str]:
    """Package -> source folder of all editable installations that have a package.xml."""
    return once("editable", _editable)


def _editable() -> dict[str, str]:
    found: dict[str, str] = {}
    for distribution in distributions():
        folder = folder_of(distribution)
        name = folder and name_in(folder)
        if folder and name:
            found.setdefault(name, folder)
    return found


def folder_of(distribution: DistInfo) -> str | None:
    """The source folder of an editable distribution; None for others."""
    text = distribution.read_text("direct_url.json")
    if text is None:
        return _folder_of_egg(distribution)
    from urllib.parse import unquote, urlsplit

    from launcher.base import strict_json

    try:
        found = strict_json.loads(text)
        url = urlsplit(found["url"])
        is_editable = found.get("dir_info", {}).get("editable", False)
    except (ValueError, TypeError, KeyError, AttributeError):
        return None
    folder = os.path.normpath(unquote(url.path))
    is_here = url.scheme == "file" and is_editable and os.path.isdir(folder)
    return folder if is_here else None


def _folder_of_egg(distribution: DistInfo) -> str | None:
    """The source folder with the egg-info that `setup.py develop` leaves: older pips call it.

    colcon calls it in a build folder, with links to the sources.
    """
    beside = distribution.folder
    if is_built_in(beside):
        return None
    return next((f for f in (beside, os.path.dirname(beside)) if name_in(f)), None)


def is_built_in(folder: str) -> bool:
    """Whether colcon has built a package in a folder."""
    return os.path.isfile(os.path.join(folder, _BUILT))


def around() -> Iterator[tuple[str, str]]:
    """(package, source folder), the nearest first.

    In the working directory, above, and the launcher's own; then below the working directory, or
    beside the package that it is in; then in the `src/` of a workspace above.
    """
    folders = (
        once("around", lambda: [*_folders_around()]) if is_reading_once() else _folders_around()
    )
    return ((name, folder) for name, folder in folders if name)


def beside(source: str) -> dict[str, str]:
    """Package -> source folder of all in the `src/` of a workspace that a package is in."""
    root = src_of(source)
    return {} if root is None else {name: folder for name, folder in _below(root) if name}


def src_of(source: str) -> str | None:
    """The `src/` that a package is in; None if it is in none."""
    root = source
    while os.path.basename(root) != "src":
        if os.path.dirname(root) == root:
            return None
        root = os.path.dirname(root)
    return root


def without_name(package: str) -> str | None:
    """A source folder called like the package whose package.xml is missing or has no name."""
    folders = (folder for name, folder in _folders_around() if not name)
    called = (folder for folder in folders if os.path.basename(folder) == package)
    return next(filter(_is_source, called), None)


def _is_source(folder: str) -> bool:
    return any(os.path.isfile(os.path.join(folder, file)) for file in _BUILD_FILES)


def _folders_around() -> Iterator[tuple[str | None, str]]:
    """(package or None, folder): all folders where a package is looked for, each once."""
    try:
        here = os.getcwd()
    except OSError:
        return
    above = [here]
    while os.path.dirname(above[-1]) != above[-1]:
        above.append(os.path.dirname(above[-1]))
    found: dict[str, None] = {}
    package = None
    for folder in (*above, _OURS):
        name = None if is_built_in(folder) else name_in(folder)
        if name:
            package = package or (folder if folder != _OURS else None)
        found[folder] = None
        yield name, folder
    roots = [here if package is None else os.path.dirname(package)]
    roots += [source for folder in above if os.path.isdir(source := os.path.join(folder, "src"))]
    for root in dict.fromkeys(roots):
        for name, folder in _below(root):
            if folder not in found:
                found[folder] = None
                yield name, folder


def _below(root: str) -> Iterator[tuple[str | None, str]]:
    """The folders below one, breadth first; like colcon, not below a package."""
    level, left = [root], _MAX_FOLDERS
    for _ in range(_MAX_DEPTH):
        folders = [below for folder in level for below in _folders_in(folder)][:left]
        left -= len(folders)
        level = []
        for folder in folders:
            name = name_in(folder)
            yield name, folder
            if not name:
                level.append(folder)


def _folders_in(folder: str) -> list[str]:
    try:
        with os.scandir(folder) as entries:
            found = sorted(entry.path for entry in entries if _may_have_sources(entry))
    except OSError:
        return []
    return [path for path in found if not _is_ignored(path)]


def _may_have_sources(entry: os.DirEntry[str]) -> bool:
    hidden = entry.name.startswith(".") or entry.name.endswith(".egg-info")
    return not hidden and entry.name not in _NO_SOURCES and entry.is_dir(follow_symlinks=False)


def _is_ignored(folder: str) -> bool:
    return any(os.path.exists(os.path.join(folder, name)) for name in _IGNORED)


def name_in(folder: str) -> str | None:
    """The name in the package.xml of a folder; None without one."""
    found = _NAME.search(_manifest(folder))
    return found and found[1]


def dependencies(folder: str) -> set[str]:
    """The packages that the package.xml of a folder names as dependencies."""
    return set(_DEPENDENCY.findall(_manifest(folder)))


def has_interfaces(folder: str) -> bool:
    """Whether the package.xml of a folder is that of messages, services and actions."""
    return "rosidl_interface_packages" in _manifest(folder)


def _manifest(folder: str) -> str:
    try:
        return text_file.read(os.path.join(folder, "package.xml"), errors="replace")
    except OSError:
        return ""


def files_in(folder: str) -> Iterator[str]:
    """The files below a source folder, without what was built there or belongs to another tool."""
    level = [folder]
    while level:
        folder = level.pop(0)
        try:
            with os.scandir(folder) as entries:
                yield from sorted(entry.path for entry in entries if entry.is_file())
        except OSError:
            continue
        level += _folders_in(folder)
