"""Packages that pip has installed from a folder or a file here: no index has them for the hosts."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from urllib.parse import urlsplit

from launcher.hosts.sync.tree import Tree
from launcher.packages import sources
from launcher.packages.sources import MARKERS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from importlib.metadata import Distribution

_KEPT = ("METADATA", "entry_points.txt", "top_level.txt")
_SITE = re.compile(r"lib/python[\d.]+/(?:site|dist)-packages")


def from_files() -> Iterator[Distribution]:
    """The distributions that were installed from this machine, and are not editable."""
    for distribution in sources.distributions():
        try:
            found = json.loads(distribution.read_text("direct_url.json") or "{}")
            is_here = urlsplit(found.get("url", "")).scheme == "file"
            is_editable = found.get("dir_info", {}).get("editable", False)
        except (ValueError, AttributeError):
            continue
        if is_here and not is_editable:
            yield distribution


def packages_of(distribution: Distribution) -> list[str]:
    """The ROS packages in it; its own name if it has none."""
    marked = (os.path.split(place) for place, _ in _files(distribution))
    names = [name for folder, name in marked if folder == MARKERS]
    return names or [distribution.metadata["Name"].replace("-", "_")]


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
    """Name -> `MODULE:OBJECT` of its console scripts."""
    points = distribution.entry_points
    return {one.name: one.value for one in points if one.group == "console_scripts"}


def _files(distribution: Distribution) -> Iterator[tuple[str, str]]:
    """(place below the prefix, path)."""
    site = os.path.normpath(str(distribution.locate_file("")))
    prefix = os.path.dirname(os.path.dirname(os.path.dirname(site)))
    for file in distribution.files or ():
        path = os.path.normpath(str(distribution.locate_file(file)))
        place = os.path.relpath(path, prefix)
        if os.path.isfile(path) and not place.startswith(("..", "bin/")):
            yield place, path


def _is_left_out(place: str) -> bool:
    """Whether a file of site-packages is about the installation here, or the launcher's own."""
    folder, _, name = place.partition("/")
    is_other = folder.endswith(".dist-info") and name not in _KEPT
    return is_other or folder == "launcher"
