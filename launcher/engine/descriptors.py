"""Descriptors: a reserve of file descriptors that processes and log files cannot use up.

Without it, the run that starts one process too many could not import a module or read /proc any
more, and would come to a bad end instead of refusing that process.
"""

from __future__ import annotations

import errno
import os

FOR_PROCESSES = 16  # left free by the streams of processes
FOR_FILES = 8  # left free by log files, too


def keep_free(fd: int, reserve: int) -> int:
    """`fd`, a descriptor that was just opened; OSError (EMFILE) if it is one of the reserve.

    The kernel gives out the lowest number that is free, so a high one tells that few are left.
    The descriptor stays open in either case.
    """
    limit = os.sysconf("SC_OPEN_MAX")  # below 0 where there is none
    if 0 < limit <= fd + reserve:
        raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))
    return fd
