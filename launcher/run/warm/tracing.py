"""LTTng-UST, which the wheels of rclpy load for their trace points.

It starts two threads when it is loaded, and has functions to be called around a fork: they hold
its locks meanwhile, and start the threads again in the new process.
"""

from __future__ import annotations

import ctypes

_SIGNAL_SET_BYTES = 128
_PREFIXES = ("lttng_ust_", "ust_")  # since 2.13, and before


class Tracing:
    """The functions of the library; AttributeError if it has none."""

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
    with open("/proc/self/maps", encoding="utf-8", errors="surrogateescape") as lines:
        paths = {line.split(None, 5)[-1].strip() for line in lines if "/liblttng-ust" in line}
    for path in sorted(paths):
        try:
            return Tracing(path)
        except (OSError, AttributeError):
            continue  # another library of it
    return None
