"""The file and line where an entity was created."""

from __future__ import annotations

import functools
import os
import sys

from launcher.base.model.record import Record
from launcher.base.text import shown_path

# The folder of the launcher, as code objects of its modules spell it.
_OWN_FILES = os.path.dirname(os.path.dirname(os.path.dirname(__file__))) + "/"
_MAX_FRAMES = 40  # deeper than any helper library; bounds the cost of a runaway recursion
# The visit of an entity, and the reading of a tag: what called them has not made the object.
_BEGINNINGS = ("language/utilities.py", "language/frontends/expose.py")
_IS_OWN: dict[str, bool | None] = {}  # by file; None: one of those, where the search ends


class FileLine(Record):
    """A file and a line in it, from 1."""

    path: str
    line: int

    def __str__(self) -> str:
        return f"{shown_path(self.path)}:{self.line}"

    @property
    def file(self) -> str:
        """The absolute path, by which a context has its files; `path` is as an include wrote it."""
        return os.path.abspath(self.path)

    @property
    def is_python(self) -> bool:
        """Whether it is to be spoken of in Python, and not with tags and `$(...)`."""
        return not self.path.endswith((".xml", ".yaml", ".yml"))


def caller_origin() -> FileLine | None:
    """The innermost frame outside of the launcher's code; None if it is not a file or too far.

    Also None if the launcher makes the object itself, in a visit or for a tag of a launch file.
    """
    frame = sys._getframe(1)
    for _ in range(_MAX_FRAMES):
        path = frame.f_code.co_filename
        is_own = _IS_OWN[path] if path in _IS_OWN else _note(path)
        if is_own is False:
            return None if path.startswith("<") else _shared(path, frame.f_lineno)
        if is_own is None or frame.f_back is None:
            return None
        frame = frame.f_back
    return None


def _note(path: str) -> bool | None:
    found = path.startswith(_OWN_FILES)
    is_beginning = found and path.removeprefix(_OWN_FILES) in _BEGINNINGS
    _IS_OWN[path] = None if is_beginning else found
    return _IS_OWN[path]


@functools.lru_cache(maxsize=64)
def _shared(path: str, line: int) -> FileLine:
    """An action creates several objects, all of them at its own place."""
    return FileLine(path, line)


def is_own_file(path: str) -> bool:
    return path.startswith(_OWN_FILES)


def is_library(path: str) -> bool:
    """Whether a file belongs to Python or to an installed package."""
    return "/site-packages/" in path or path.startswith(os.path.dirname(os.__file__) + "/")
