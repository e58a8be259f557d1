"""Packages that pip has installed from a folder or a file here: no index has them for the hosts."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from importlib import metadata
from urllib.parse import urlsplit

from launcher.base import strict_json
from launcher.hosts.sync.release_tree import Tree
from launcher.packages.entry_points import PROGRAMS
from launcher.packages.extras import DISTRIBUTION
from launcher.packages.source_packages import MARKERS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from importlib.metadata import Distribution

_KEPT = ("METADATA", "PKG-INFO", "entry_points.txt", "top_level.txt")
# What pip before 23.1 leaves of a package without pyproject.toml where `wheel` is not installed: an
# egg-info with this list, which does not say where the package is from.
_LEGACY_FILES = "installed-files.txt"
_SITE = re.compile(r"lib/python[\d.]+/(?:site|dist)-packages")


def from_files() -> Iterator[Distribution]:
    """The distributions that were installed from this machine, and are not editable, nor ours.

    Of those that do not say where they are from, the ones with a ROS package.
    """
    for distribution in metadata.distributions():
        if distribution.read_text(_LEGACY_FILES) is not None and _marked(distribution):
            yield distribution
            continue
        try:
            found = strict_json.loads(distribution.read_text("direct_url.json") or "{}")
            is_here = urlsplit(found.get("url", "")).scheme == "file"
            is_editable = found.get("dir_info", {}).get("editable", False)
        except (ValueError, AttributeError):
            continue
        is_launcher = distribution.metadata["Name"] == DISTRIBUTION
        if is_here and not is_editable and not is_launcher:
            yield distribution


def packages_of(distribution: Distribution) -> list[str]:
    """The ROS packages in it; its own name if it has none."""
    return _marked(distribution) or [distribution.metadata["Name"].replace("-", "_")]


def _marked(distribution: Distribution) -> list[str]:
    places = (os.path.split(place) for place, _ in _files(distribution))
    return [name for folder, name in places if folder == MARKERS]


def add(tree: Tree, distribution: Distribution, top: str, pure: str) -> str:
    """Add its files below `top`; the folder of its modules there, `pure` if none is compiled."""
    files = dict(_files(distribution))
    compiled = any(place.endswith(".so") for place in files)
    found = pure
    for place, path in files.items():
        site = _SITE.match(place)
        if site is not None and _is_left_out(place[site.end() + 1 :]):
            continue
        if site is not None:
            found = site[0] if compiled else pure
            place = f"{found}{place[site.end() :]}"
        tree.add_file(f"{top}/{place}", path, [os.path.dirname(path)])
    return found


def programs(distribution: Distribution) -> dict[str, str]:
    """Name -> `MODULE:OBJECT` of its programs."""
    points = distribution.entry_points
    groups = ("console_scripts", PROGRAMS)
    return {one.name: one.value for one in points if one.group in groups}


def _files(distribution: Distribution) -> Iterator[tuple[str, str]]:
    """(place below the prefix, path)."""
    site = os.path.normpath(str(distribution.locate_file("")))
    prefix = os.path.dirname(os.path.dirname(os.path.dirname(site)))
    for file in _listed(distribution):
        path = os.path.normpath(str(distribution.locate_file(file)))
        place = os.path.relpath(path, prefix)
        if os.path.isfile(path) and not place.startswith(("..", "bin/")):
            yield place, path


def _listed(distribution: Distribution) -> Iterable[str | os.PathLike[str]]:
    """Paths relative to site-packages."""
    legacy = distribution.read_text(_LEGACY_FILES)
    if legacy is None:
        return distribution.files or ()
    # The list is relative to the egg-info, whose name importlib does not expose.
    folder = os.path.basename(str(getattr(distribution, "_path", "")))
    return [os.path.join(folder, line) for line in legacy.splitlines() if line]


def _is_left_out(place: str) -> bool:
    """Whether a file of site-packages is about the installation here."""
    folder, _, name = place.partition("/")
    return folder.endswith((".dist-info", ".egg-info")) and name not in _KEPT
