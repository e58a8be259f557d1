"""The limit of open files: raised when the launcher needs more, and as before for its children.

A program may take its limit for the number of descriptors that it has to close, or use select(),
which fails from 1024 on: the soft limit of children is what the launcher was started with.
"""

from __future__ import annotations

import contextlib
import os
import resource
from collections.abc import Iterator, Sequence

_first = 0  # the soft limit that we were started with, if we have raised it
_raised = 0
_reserved: list[int] = []  # low numbers: /dev/null, and one for each stream of a new child


def raise_limit() -> int:
    """Raise the soft limit to the hard one, if it is lower; the soft limit then."""
    global _first, _raised
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft != hard:
        try:
            resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
        except (OSError, ValueError):  # the kernel's own limit is lower by now
            return soft
        _first, _raised = _first or soft, hard
        while len(_reserved) < 4:
            _reserved.append(os.open(os.devnull, os.O_RDWR | os.O_CLOEXEC))
    return hard


def is_raised() -> bool:
    """Whether a child that is started just so would have more than the launcher had at first."""
    return _raised > 0


@contextlib.contextmanager
def for_child(streams: Sequence[int]) -> Iterator[Sequence[int]]:
    """Within, a child gets the first limit; the streams under numbers that posix_spawn accepts.

    With a limit of 64 it refuses any number above 63, also of an open descriptor.
    """
    if not _raised or _reserved[-1] >= _first:
        yield streams
        return
    null, *low = _reserved
    for fd, number in zip(streams, low, strict=True):
        os.dup2(fd, number, inheritable=False)
    lower()
    try:
        yield low
    finally:
        _change(_first, _raised)
        for number in low:
            os.dup2(null, number, inheritable=False)


def lower() -> None:
    """Set the first limit, in a child; nothing if somebody else has set one since it was raised."""
    _change(_raised, _first)


def _change(before: int, after: int) -> None:
    if _raised:
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        if soft == before:
            resource.setrlimit(resource.RLIMIT_NOFILE, (min(after, hard), hard))
