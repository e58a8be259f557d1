"""What pip has noted about installed distributions, read without `importlib.metadata`.

That takes 20 ms to import, and a fleet whose package is not in the index waits for it before its
first process. Where a distribution may be anywhere but in a folder of `sys.path`, it is asked.
"""

from __future__ import annotations

import os
import re
import sys
from importlib.machinery import PathFinder

from launcher.base.model.record import Record

TYPE_CHECKING = False
if TYPE_CHECKING:
    from importlib.metadata import Distribution

_SEPARATORS = re.compile(r"[-_.]+")
_VALUE = re.compile(r"(?P<module>[\w.]+)\s*(:\s*(?P<attr>[\w.]+))?")
_ENDS = (".dist-info", ".egg-info")


class Point(Record):
    """An entry point: `NAME = MODULE:ATTR` below `[GROUP]`."""

    group: str
    name: str
    module: str
    attr: str


class DistInfo:
    """The folder of metadata of a distribution, or what `importlib.metadata` has found."""

    __slots__ = ("_found", "_path")

    def __init__(self, path: str, found: Distribution | None = None) -> None:
        self._path = path
        self._found = found

    @property
    def whole(self) -> Distribution:
        if self._found is None:
            from importlib.metadata import PathDistribution
            from pathlib import Path

            self._found = PathDistribution(Path(self._path))
        return self._found

    @property
    def folder(self) -> str:
        """Where its modules are; empty if that is no folder."""
        if self._found is not None:
            return os.path.normpath(str(self._found.locate_file("")))
        return os.path.normpath(os.path.dirname(self._path))

    def read_text(self, name: str) -> str | None:
        """A file of the metadata; None if there is none."""
        if self._found is not None:
            return self._found.read_text(name)
        try:
            with open(os.path.join(self._path, name), encoding="utf-8") as file:
                return file.read()
        except OSError:
            return None

    @property
    def points(self) -> list[Point]:
        found: list[Point] = []
        group = ""
        for line in map(str.strip, (self.read_text("entry_points.txt") or "").splitlines()):
            name, equals, value = (part.strip() for part in line.partition("="))
            if line.startswith("[") and line.endswith("]"):
                group = line[1:-1]
            elif equals and not line.startswith("#") and (match := _VALUE.match(value)):
                found.append(Point(group, name, match["module"], match["attr"] or ""))
        return found


def installed(name: str | None = None) -> list[DistInfo]:
    """Installed distributions, of this name or all.

    There may be two: an egg-info without files in the source tree, and what is installed from it.
    """
    if name == "":  # for importlib, that is any
        return []
    others = [one for one in sys.meta_path if hasattr(one, "find_distributions")]
    if others != [PathFinder] or any(map(os.path.isfile, sys.path)):
        from importlib import metadata

        found = metadata.distributions() if name is None else metadata.distributions(name=name)
        return [DistInfo("", one) for one in found]
    wanted = None if name is None else _normal(name)
    return [DistInfo(path) for folder in sys.path for path in _in(folder or ".", wanted)]


def _in(folder: str, wanted: str | None) -> list[str]:
    try:
        names = os.listdir(folder)
    except OSError:
        return []
    if folder.endswith(".egg") and "EGG-INFO" in names:
        stem = os.path.basename(folder).partition("-")[0]
        return [f"{folder}/EGG-INFO"] if wanted in (None, _normal(stem)) else []
    found = [name for name in names if name.lower().endswith(_ENDS)]
    if wanted is not None:
        found = [name for name in found if _normal(_stem(name)) == wanted]
    return [os.path.join(folder, name) for name in found]


def _stem(name: str) -> str:
    return name.rpartition(".")[0].partition("-")[0]


def _normal(name: str) -> str:
    return _SEPARATORS.sub("-", name).lower()
