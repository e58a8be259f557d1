"""Whether what was imported is still what is on disk."""

from __future__ import annotations

import os
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator

    Stamp = tuple[int, int, int]


class Stamps:
    """Of each file its time in nanoseconds, size and inode; of a folder its time."""

    def __init__(self, stamps: dict[str, Stamp]) -> None:
        self._stamps = stamps

    @classmethod
    def of_what_is_loaded(cls) -> Stamps:
        """Of all modules and shared libraries, and of the folders with installed packages.

        pip creates or removes an entry there with every change.
        """
        paths = {*_modules(), *_libraries(), *_folders()}
        return cls({path: stamp for path in paths if (stamp := _stamp(path)) is not None})

    def first_change(self) -> str | None:
        """A path that has changed; None if there is none. A thousand take 2 ms."""
        return next((path for path, then in self._stamps.items() if _stamp(path) != then), None)


def _stamp(path: str) -> Stamp | None:
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino


def _modules() -> Iterator[str]:
    for module in list(sys.modules.values()):
        file = getattr(module, "__file__", None)
        if isinstance(file, str):
            yield file


def _libraries() -> Iterator[str]:
    with open("/proc/self/maps", encoding="utf-8", errors="surrogateescape") as lines:
        for line in lines:
            words = line.split(None, 5)
            path = words[5].rstrip("\n") if len(words) == 6 else ""
            if path.startswith("/") and not path.startswith(("/dev/", "/memfd:")):
                yield path


def _folders() -> Iterator[str]:
    """Not all of `sys.path`: a source folder changes whenever a file in it is saved."""
    names = ("site-packages", "dist-packages")
    return (path for path in sys.path if os.path.basename(path) in names and os.path.isdir(path))
