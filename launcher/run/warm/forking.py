"""Forks a process whose parent is the launcher.

The process in between exits at once, so that the launcher, which adopts orphans, becomes the
parent; that is the case when `fork` returns.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import sys
import warnings

from launcher.posix import proc

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator


class Forker:
    """Forks; `tracing` is the library whose threads have to be there again in the new process."""

    def __init__(self, tracing: Tracing | None) -> None:
        self._tracing = tracing

    def fork(self, *, leads_session: bool = True) -> int:
        """The pid of the new process; 0 in it."""
        theirs, ours = os.pipe()
        between = self.fork_child()
        if between == 0:
            with _quiet():
                is_between = os.fork() != 0
            if is_between:
                os._exit(0)
            if leads_session:
                os.setsid()
            os.write(ours, b"%d" % os.getpid())
            os.close(ours)
            os.close(theirs)
            return 0
        os.close(ours)
        os.waitpid(between, 0)
        try:
            return int(os.read(theirs, 32) or -1)
        finally:
            os.close(theirs)

    def fork_child(self) -> int:
        """As `os.fork`: a child of our own, whose threads can be restored."""
        if self._tracing is not None:
            self._tracing.before_fork()
        with _quiet():
            pid = os.fork()
        if pid and self._tracing is not None:
            self._tracing.after_fork_in_parent()
        return pid

    def restore_threads(self) -> None:
        """To be called in the new process, when it has its descriptors."""
        if self._tracing is not None:
            self._tracing.after_fork_in_child()


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Python 3.12 warns of threads; those that there may be have been provided for."""
    if sys.version_info < (3, 12):
        yield
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        yield


# ---- LTTng

_SIGNAL_SET_BYTES = 128
_PREFIXES = ("lttng_ust_", "ust_")  # since 2.13, and before


class Tracing:
    """LTTng-UST, which the wheels of rclpy load for their trace points; AttributeError without it.

    It starts two threads when it is loaded, and has functions to be called around a fork: they
    hold its locks meanwhile, and start the threads again in the new process.
    """

    def __init__(self, path: str) -> None:
        library = ctypes.CDLL(path)
        prefix = next((one for one in _PREFIXES if hasattr(library, f"{one}before_fork")), "ust_")
        self._before = library[f"{prefix}before_fork"]
        self._in_parent = library[f"{prefix}after_fork_parent"]
        self._in_child = library[f"{prefix}after_fork_child"]
        self._blocked = ctypes.create_string_buffer(_SIGNAL_SET_BYTES)

    def before_fork(self) -> None:
        """Also blocks all signals, until one of the others is called."""
        self._before(self._blocked)

    def after_fork_in_parent(self) -> None:
        self._in_parent(self._blocked)

    def after_fork_in_child(self) -> None:
        self._in_child(self._blocked)


def loaded() -> Tracing | None:
    """The library, if it is loaded."""
    for path in sorted(path for path in proc.mapped(os.getpid()) if "/liblttng-ust" in path):
        try:
            return Tracing(path)
        except (OSError, AttributeError):
            continue  # another library of it
    return None
