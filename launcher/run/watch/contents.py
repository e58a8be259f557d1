"""What is in files, and whether that has changed."""

from __future__ import annotations

import hashlib
import os

from launcher.base.model.record import Record


class State(Record):
    """A file at one moment; a file that does not exist has no `stamp`.

    `changed_ns`: when its content was changed or it was put there, in nanoseconds since 1970.
    """

    stamp: tuple[int, ...] | None = None
    changed_ns: int = 0


def state_of(path: str) -> State:
    """Its present state; a link has changed also if it leads elsewhere."""
    try:
        link, file = os.lstat(path), os.stat(path)
    except OSError:
        return State()
    stamp = (file.st_dev, file.st_ino, file.st_size, file.st_mtime_ns, file.st_ctime_ns)
    return State((*stamp, link.st_ino), max(link.st_ctime_ns, file.st_ctime_ns))


def content_of(path: str) -> bytes | None:
    """None if it cannot be read."""
    try:
        with open(path, "rb") as file:
            return file.read()
    except OSError:
        return None


def digest_of(path: str) -> str | None:
    """Equal for equal contents; None if it cannot be read."""
    content = content_of(path)
    return None if content is None else hashlib.blake2b(content, digest_size=16).hexdigest()
