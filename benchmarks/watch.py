"""The times at which programs are exec'd and at which they exit, by inotify.

The kernel opens a program's file when it is exec'd and closes it when the last process that runs
it ends, so watching a copy of a program needs no cooperation of the program.
"""

from __future__ import annotations

import ctypes
import os
import select
import struct
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

_IN_OPEN, _IN_CLOSE_NOWRITE = 0x20, 0x10
_HEADER = struct.Struct("iIII")
_READ_BYTES = 64 * 1024


class Seen(NamedTuple):
    """`died` is False for an exec; `when_s` is monotonic time."""

    when_s: float
    name: str
    died: bool


class ExecWatch:
    """Watches the programs in a folder from a thread; use `with`."""

    def __init__(self, folder: Path) -> None:
        self.events: list[Seen] = []
        self._changed = threading.Condition()
        libc = ctypes.CDLL(None, use_errno=True)
        self._fd: int = libc.inotify_init1(os.O_CLOEXEC | os.O_NONBLOCK)
        mask = _IN_OPEN | _IN_CLOSE_NOWRITE
        if self._fd < 0 or libc.inotify_add_watch(self._fd, bytes(folder), mask) < 0:
            raise OSError(ctypes.get_errno(), "inotify", str(folder))
        self._stop_read, self._stop_write = os.pipe()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def __enter__(self) -> ExecWatch:
        return self

    def __exit__(self, *exc: object) -> None:
        os.close(self._stop_write)
        self._thread.join()
        os.close(self._stop_read)
        os.close(self._fd)

    def execs(self) -> list[float]:
        """When programs were exec'd, in order."""
        return [seen.when_s for seen in list(self.events) if not seen.died]

    def wait_for_execs(self, count: int, timeout_s: float = 30.0) -> list[float]:
        """Wait until `count` programs have been exec'd; raises TimeoutError."""
        return self._wait(lambda: len(self.execs()) >= count and self.execs(), timeout_s)

    def _wait(self, fact: Callable[[], list[float] | bool], timeout_s: float) -> list[float]:
        with self._changed:
            found = self._changed.wait_for(fact, timeout_s)
        if not isinstance(found, list):
            raise TimeoutError(f"too few programs exec'd or exited within {timeout_s} s")
        return found

    def _serve(self) -> None:
        poll = select.poll()
        poll.register(self._fd, select.POLLIN)
        poll.register(self._stop_read, select.POLLIN | select.POLLHUP)
        while not any(fd == self._stop_read for fd, _ in poll.poll()):
            data, now = os.read(self._fd, _READ_BYTES), time.monotonic()
            with self._changed:
                self.events += _parsed(data, now)
                self._changed.notify_all()


def _parsed(data: bytes, now: float) -> list[Seen]:
    seen, offset = [], 0
    while offset < len(data):
        _, mask, _, size = _HEADER.unpack_from(data, offset)
        offset += _HEADER.size
        name = data[offset : offset + size].rstrip(b"\0").decode()
        offset += size
        if name and mask & (_IN_OPEN | _IN_CLOSE_NOWRITE):
            seen.append(Seen(now, name, bool(mask & _IN_CLOSE_NOWRITE)))
    return seen
