"""Processes that a build has started, directly or not."""

from __future__ import annotations

import ctypes
import os
import signal
import time
from collections.abc import Collection

from launcher.posix import proc

_PR_SET_CHILD_SUBREAPER = 36
_WAIT_S = 0.01  # one that waits for a disk dies late


def adopt() -> None:
    """Become the parent of descendants whose own parent has ended, so that they can be found."""
    ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def kill(spared: Collection[int] = ()) -> None:
    """Kill all descendants of this process but these children, until there are none.

    Those that may not be killed, since they have become another user's, are left.
    """
    own = os.getpid()
    left: set[int] = set()
    while below := {*proc.family(set(proc.children(own)) - {*spared})} - left:
        for pid in below:
            try:
                os.kill(pid, signal.SIGKILL)
            except PermissionError:
                left.add(pid)
            except ProcessLookupError:
                pass
        time.sleep(_WAIT_S)
