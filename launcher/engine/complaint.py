"""Complaint: a word on standard error, where standard output takes none."""

from __future__ import annotations

import contextlib
import os


def complain(text: str, *, shown_fd: int = 1, fd: int = 2) -> None:
    """Say it on `fd` if that is another file than `shown_fd`; never wait for a reader, nor fail."""
    with contextlib.suppress(OSError):
        if os.path.sameopenfile(shown_fd, fd) or not _takes_some(fd):
            return
        os.write(fd, f"error: {text}\n".encode(errors="surrogateescape"))


def _takes_some(fd: int) -> bool:
    import select

    poll = select.poll()
    poll.register(fd, select.POLLOUT)
    return bool(poll.poll(0))
