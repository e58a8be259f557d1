"""Pipes that hold more than the usual 64 KiB, as long as that leaves others theirs.

Linux counts what all pipes of a user may hold (pipe(7), `pipe-user-pages-soft`, 64 MiB). Above that
an unprivileged user may not enlarge a pipe (EPERM), and each new pipe of the user holds 8 KiB, of
whatever program: those of the next processes of a run, too. So a process takes no more than a
SHARE of it for all pipes that it enlarges, and for each of them a part of what is left of it.
"""

from __future__ import annotations

import fcntl
import os

from launcher.posix import proc

SHARE = 0.25  # of what the user may have
PART = 0.125  # of the rest of the share, for one pipe: 10 of 1 MiB, then smaller ones
_USUAL_PAGES = 16384  # the limit where /proc does not show it

_wide: dict[int, tuple[int, int]] = {}  # descriptor -> its inode, the bytes that were added


def widen(fd: int, size: int) -> None:
    """Have a pipe hold `size` bytes, a power of two, or as much of that as the share has left.

    No error if it is a socket, or if the limit of the user is reached.
    """
    _forget_closed()
    most = PART * (_share_bytes() - sum(added for _, added in _wide.values()))
    try:
        before = fcntl.fcntl(fd, fcntl.F_GETPIPE_SZ)
        while size > before and size - before > most:
            size //= 2
        if size > before:
            fcntl.fcntl(fd, fcntl.F_SETPIPE_SZ, size)
            _wide[fd] = (os.fstat(fd).st_ino, size - before)
    except OSError:
        return


def _share_bytes() -> float:
    text = proc.read("sys/fs", "pipe-user-pages-soft").strip()
    pages = int(text) if text.isdigit() else _USUAL_PAGES
    return SHARE * pages * os.sysconf("SC_PAGE_SIZE") if pages else float("inf")  # 0: no limit


def _forget_closed() -> None:
    for fd, (inode, _) in list(_wide.items()):
        try:
            is_open = os.fstat(fd).st_ino == inode
        except OSError:
            is_open = False
        if not is_open:
            del _wide[fd]
