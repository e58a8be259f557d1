"""One build at a time in a workspace."""

from __future__ import annotations

import contextlib
import fcntl
import functools
import os
import sys
import time
from collections.abc import Callable, Iterator

from launcher.base.errors import LauncherError
from launcher.workspace.building.build_place import Place, not_written

_NAME = ".launcher.lock"


@contextlib.contextmanager
def held(place: Place, say: Callable[[str], None] | None = None) -> Iterator[int]:
    """Hold the lock of the workspace; its descriptor. If it has to wait, it says for whom.

    The lock is gone when the last process with the descriptor is, so it is never stale; colcon
    inherits it, and a build that is killed holds it until its compilers have ended.
    """
    path = os.path.join(place.build, _NAME)
    file = _opened(path)
    try:
        _take(file, say or functools.partial(print, file=sys.stderr))
        _sign(file, path)
        yield file
        os.ftruncate(file, 0)
    finally:
        os.close(file)


def _opened(path: str) -> int:
    try:
        os.makedirs(os.path.dirname(path), exist_ok=True)
        return os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
    except OSError as error:
        raise not_written(path, error) from None


def _sign(file: int, path: str) -> None:
    """Write who holds the lock."""
    holder = f"process {os.getpid()}, since {time.strftime('%H:%M:%S')}"
    try:
        os.ftruncate(file, 0)
        os.pwrite(file, holder.encode(), 0)
    except OSError as error:
        raise not_written(path, error) from None


def _take(file: int, say: Callable[[str], None]) -> None:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return
    except BlockingIOError:
        pass
    except OSError as error:  # a file system without locks
        raise LauncherError(f"cannot lock the folder build/: {error.strerror}") from error
    holder = os.pread(file, 200, 0).decode(errors="replace") or "another process"
    say(f"waiting for {holder}, which builds or tests in this workspace")
    fcntl.flock(file, fcntl.LOCK_EX)
