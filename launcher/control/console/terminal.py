"""Writes to the terminal without blocking, and reports when it is slow."""

from __future__ import annotations

import asyncio
import contextlib
import os
import select
import termios
import time
from collections.abc import Callable
from typing import Any

from prompt_toolkit.data_structures import Size
from prompt_toolkit.input.vt100 import raw_mode

STALLED_S = 5.0  # without a byte taken, after which nothing more is expected
POLL_S = 0.5
WIDTH, HEIGHT = 80, 24  # of a terminal of unknown size


def _opened_again(fd: int) -> int:
    """A non-blocking descriptor of the same terminal; the inherited one is shared."""
    try:
        return os.open(
            f"/proc/self/fd/{fd}", os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC
        )
    except OSError:  # after `su` it belongs to another user
        return fd


class Terminal:
    """Writes to standard output; `attrs` are the settings that `restore` brings back.

    `on_slow(True)` is called when output is waiting, `on_slow(False)` when it is written, and
    `on_gone()` when the terminal is closed.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._fd = _opened_again(1)
        self.attrs = termios.tcgetattr(0)
        self._waiting = b""
        self.on_slow: Callable[[bool], None] = lambda slow: None
        self.on_gone: Callable[[], None] = lambda: None

    def size(self) -> Size:
        try:
            columns, rows = os.get_terminal_size(self._fd)
        except OSError:
            columns, rows = 0, 0
        return Size(rows=rows or HEIGHT, columns=columns or WIDTH)

    @staticmethod
    def is_ours() -> bool:
        """Whether we are in the foreground, and may read and change settings."""
        try:
            return os.tcgetpgrp(0) == os.getpgrp()
        except OSError:
            return True  # the launcher was the session leader and has exited

    @property
    def is_slow(self) -> bool:
        """Whether output is waiting."""
        return bool(self._waiting)

    def write(self, data: bytes) -> None:
        """Write `data` after what is waiting."""
        if self._waiting:
            self._waiting += data
            return
        self._waiting = self._try(data)
        if self._waiting:
            self._loop.add_writer(self._fd, self._flush)
            self.on_slow(True)

    def _flush(self) -> None:
        self._waiting = self._try(self._waiting)
        if not self._waiting:
            self._loop.remove_writer(self._fd)
            self.on_slow(False)

    def _try(self, data: bytes) -> bytes:
        try:
            while data:
                data = data[os.write(self._fd, data) :]
        except BlockingIOError:
            return data
        except OSError:
            self.on_gone()  # EIO: closed
        return b""

    def drain(self) -> None:
        """Write what is waiting; give up when nothing was taken for STALLED_S."""
        poll = select.poll()
        poll.register(self._fd, select.POLLOUT)
        taken_at_s = time.monotonic()
        while self._waiting and time.monotonic() - taken_at_s < STALLED_S:
            poll.poll(POLL_S * 1000)
            before = len(self._waiting)
            self._flush()
            if len(self._waiting) < before:
                taken_at_s = time.monotonic()

    def restore(self) -> None:
        """Restore the settings, unless we are in the background."""
        if self.is_ours():
            self._set(self.attrs)

    def set_raw(self) -> None:
        """Raw mode as in prompt_toolkit."""
        with raw_mode(0):
            raw = termios.tcgetattr(0)
        self._set(raw)

    @staticmethod
    def _set(attrs: list[Any]) -> None:
        with contextlib.suppress(termios.error):  # the window was closed
            termios.tcsetattr(0, termios.TCSANOW, attrs)
