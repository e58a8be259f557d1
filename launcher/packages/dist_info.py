"""What pip has noted about installed distributions, read without `importlib.metadata`.

That takes 20 ms to import, and a fleet whose package is not in the index waits for it before its
first process. Where a distribution may be anywhere but in a folder of `sys.path`, it is asked.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from importlib.machinery import PathFinder

from launcher.base.model.record import Record
from launcher.packages import once

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
        """A file of the metadata; None if there is none that is text."""
        if self._found is not None:
            return self._found.read_text(name)
        try:
            with open(os.path.join(self._path, name), encoding="utf-8") as file:
                return file.read()
        except (OSError, UnicodeError):
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
    # Python ignores entries that are no texts, which launch files add (`Path(__file__).parent`).
    folders = [one for one in sys.path if isinstance(one, str)]
    others = [one for one in sys.meta_path if hasattr(one, "find_distributions")]
    if others != [PathFinder] or any(map(os.path.isfile, folders)):
        from importlib import metadata

        found = metadata.distributions() if name is None else metadata.distributions(name=name)
        return [DistInfo("", one) for one in found]
    wanted = None if name is None else _normal(name)
    listed = once(repr(folders), lambda: [one for folder in folders for one in _in(folder or ".")])
    return [DistInfo(path) for known, path in listed if wanted in (None, known)]


def _in(folder: str) -> Iterator[tuple[str, str]]:
    """(normalised name, folder of metadata) of each distribution in a folder of modules."""
    try:
        names = os.listdir(folder)
    except OSError:
        return
    if folder.endswith(".egg") and "EGG-INFO" in names:
        yield _normal(_stem(os.path.basename(folder))), f"{folder}/EGG-INFO"
        return
    found = [name for name in names if name.lower().endswith(_ENDS)]
    stems = _normal("/".join(map(_stem, found))).split("/")  # all at once, which is quicker
    yield from zip(stems, (os.path.join(folder, name) for name in found), strict=False)


def _stem(name: str) -> str:
    return name.rpartition(".")[0].partition("-")[0]


def _normal(name: str) -> str:
    return _SEPARATORS.sub("-", name).lower()
