"""The times at which programs are exec'd and at which they exit, by fanotify.

The kernel reports when a file is opened in order to execute it, and when it is closed, which is
when the last process that runs it ends. So watching a copy of a program needs no cooperation of
the program. inotify does not say why a file is opened: the launcher reads the first bytes of each
program before the first start, which looked like an exec and an exit.
"""

from __future__ import annotations

import ctypes
import os
import select
import struct
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from benchmarks.harness import NotHereError

_OPEN_EXEC, _CLOSE_NOWRITE, _ON_CHILD = 0x1000, 0x10, 0x0800_0000
_CLOEXEC, _NONBLOCK, _REPORT_DIRECTORY_AND_NAME = 0x1, 0x2, 0x400 | 0x800
_MARK_ADD = 0x1
_AT_FDCWD = -100
_HEADER = struct.Struct("IBBHQii")  # length, version, reserved, length of this, mask, fd, pid
_NAME_INFO = 2  # FAN_EVENT_INFO_TYPE_DFID_NAME
_INFO = struct.Struct("BBH8sIi")  # type, padding, length, file system, bytes and type of the handle
_READ_BYTES = 64 * 1024


class Seen(NamedTuple):
    """`died` is False for an exec; `when_s` is monotonic time."""

    when_s: float
    name: str
    died: bool


class ExecWatch:
    """Watches the programs in a folder from a thread; use `with`. NotHereError."""

    def __init__(self, folder: Path) -> None:
        self.events: list[Seen] = []
        self._running: dict[str, int] = {}
        self._changed = threading.Condition()
        self._fd = _watch(folder)
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
                for mask, name in _parsed(data):
                    self._note(mask, name, now)
                self._changed.notify_all()

    def _note(self, mask: int, name: str, now: float) -> None:
        """The kernel may report an exec and the exit after it as one."""
        if mask & _OPEN_EXEC:
            self.events.append(Seen(now, name, died=False))
            self._running[name] = self._running.get(name, 0) + 1
        if mask & _CLOSE_NOWRITE and self._running.get(name):  # else: it was only read
            self.events.append(Seen(now, name, died=True))
            self._running[name] -= 1


def _watch(folder: Path) -> int:
    """The descriptor of a new fanotify group that reports execs and exits; NotHereError."""
    libc = ctypes.CDLL(None, use_errno=True)
    fd: int = libc.fanotify_init(_CLOEXEC | _NONBLOCK | _REPORT_DIRECTORY_AND_NAME, 0)
    if fd >= 0:
        mask = ctypes.c_uint64(_OPEN_EXEC | _CLOSE_NOWRITE | _ON_CHILD)
        if libc.fanotify_mark(fd, _MARK_ADD, mask, _AT_FDCWD, bytes(folder)) == 0:
            return fd
        error = ctypes.get_errno()
        os.close(fd)
    else:
        error = ctypes.get_errno()
    raise NotHereError(f"fanotify of execs in {folder} (Linux 5.13): {os.strerror(error)}")


def _parsed(data: bytes) -> Iterator[tuple[int, str]]:
    """(mask, name) of each event; see `man 7 fanotify`."""
    offset = 0
    while offset < len(data):
        length, _, _, head_length, mask, _, _ = _HEADER.unpack_from(data, offset)
        at = offset + head_length
        offset += length
        while at < offset:
            kind, _, info_length, _, handle_bytes, _ = _INFO.unpack_from(data, at)
            if kind == _NAME_INFO:
                name = data[at + _INFO.size + handle_bytes : at + info_length]
                yield mask, os.fsdecode(name.partition(b"\0")[0])
            at += info_length
