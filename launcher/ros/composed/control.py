"""The connection to the launcher: a socket that keeps the bounds of messages.

It comes as standard input, and is moved to another descriptor, which neither the programs of
members have nor what they start. `token`, `INDEX node NAME LOGGER` and `INDEX exit CODE` go out,
`INDEX SIGNAL` comes in, for one member only.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
from collections.abc import Iterator

_MOST_BYTES = 4096
_LOW = 3
_fd = -1


def take() -> None:
    """Move it away from standard input, where there is nothing from now on."""
    global _fd
    _fd = fcntl.fcntl(0, fcntl.F_DUPFD_CLOEXEC, _LOW)
    null = os.open(os.devnull, os.O_RDONLY)
    os.dup2(null, 0)
    os.close(null)


def send(*words: object) -> None:
    """Send a message at once and whole, from any thread."""
    with contextlib.suppress(OSError):  # the launcher is gone
        os.write(_fd, " ".join(map(str, words)).encode())


def requests() -> Iterator[tuple[int, int]]:
    """(member, signal) until the launcher is gone."""
    with contextlib.suppress(OSError):
        while message := os.read(_fd, _MOST_BYTES):
            index, _, signum = message.strip().partition(b" ")
            if index.isdigit() and signum.isdigit():
                yield int(index), int(signum)
