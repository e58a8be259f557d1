"""Programs of installed Python packages: console scripts, and those that are not for PATH.

A package whose programs hide others on PATH (`robot`) names them in the group `launcher.programs`
of its entry points, and pip makes nothing of them.

Of all packages that name a script alike, pip leaves the file of the last one in `bin`, and removes
it with any of them. The others get a script of ours, below the temporary directory.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from launcher.packages import source_packages

PROGRAMS = "launcher.programs"

TYPE_CHECKING = False
if TYPE_CHECKING:
    from importlib.metadata import Distribution

    from launcher.packages.dist_info import Point


def programs(package: str) -> Iterator[tuple[str, Path]]:
    """(name, path) of the programs of distributions with this name."""
    for distribution in source_packages.distributions(package):
        found = distribution.points
        if source_packages.folder_of(distribution) is None:  # else the overlay has them
            yield from ((e.name, _script_of_ours(package, e)) for e in found if e.group == PROGRAMS)
        points = {e.name: e for e in found if e.group == "console_scripts"}
        for path in _installed(distribution.whole) if points else ():
            if path.name in points:
                yield path.name, _own_script(package, points[path.name], path)


def _installed(distribution: Distribution) -> Iterator[Path]:
    """The files in `bin` that pip has noted for this distribution, also if they are gone."""
    if not any(map(distribution.read_text, ("RECORD", "installed-files.txt"))):
        return  # its files would be the sources: of an egg-info in their folder
    for file in distribution.files or ():
        path = Path(os.path.normpath(str(distribution.locate_file(file))))
        if path.parent.name == "bin":
            yield path


def _own_script(package: str, point: Point, path: Path) -> Path:
    """The installed script if it calls this entry point, else one that does."""
    return path if _calls(path, point) else _script_of_ours(package, point)


def _script_of_ours(package: str, point: Point) -> Path:
    from launcher.packages import overlay

    return Path(overlay.script(package, point.name, f"{point.module}:{point.attr}"))


def _calls(path: Path, point: Point) -> bool:
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False
    wanted = f"from {point.module} import {point.attr.partition('.')[0]}"
    return wanted in map(str.strip, text.splitlines())
