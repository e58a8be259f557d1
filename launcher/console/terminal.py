"""Terminal: the one writer of the terminal, which never blocks and says when it cannot follow."""

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

WIDTH, HEIGHT = 80, 24  # where the terminal does not tell


def _opened_again(fd: int) -> int:
    """The same terminal without blocking: O_NONBLOCK on what we inherited would be everybody's."""
    try:
        return os.open(
            f"/proc/self/fd/{fd}", os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC
        )
    except OSError:  # after `su` it belongs to somebody else
        return fd


class Terminal:
    """Writes to the terminal on standard output; `attrs` is how it was when we came.

    `on_slow(True)` is called when something waits to be written, `on_slow(False)` when it has
    gone; `on_gone()` when the terminal is no more.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._fd = _opened_again(1)
        self.attrs = termios.tcgetattr(0)
        self._waiting = b""
        self.on_slow: Callable[[bool], None] = lambda slow: None
        self.on_gone: Callable[[], None] = lambda: None

    def size(self) -> Size:
        """Rows and columns as they are now."""
        try:
            columns, rows = os.get_terminal_size(self._fd)
        except OSError:
            columns, rows = 0, 0
        return Size(rows=rows or HEIGHT, columns=columns or WIDTH)

    @staticmethod
    def is_ours() -> bool:
        """Whether we are in the foreground, so that we may read and change settings."""
        try:
            return os.tcgetpgrp(0) == os.getpgrp()
        except OSError:
            return True  # the launcher led the session and has died: nobody else has it

    def write(self, data: bytes) -> None:
        """Write this behind what waits."""
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
            self.on_gone()  # EIO: the window was closed
        return b""

    def drain(self, patience_s: float) -> None:
        """Write what waits, giving a slow terminal so much time."""
        deadline = time.monotonic() + patience_s
        poll = select.poll()
        poll.register(self._fd, select.POLLOUT)
        while self._waiting and (left_s := deadline - time.monotonic()) > 0:
            poll.poll(left_s * 1000)
            self._flush()

    def restore(self) -> None:
        """The settings as they were, if nobody else has the terminal by now."""
        if self.is_ours():
            self._set(self.attrs)

    def set_raw(self) -> None:
        """Keys one by one, unseen and without signals, as prompt_toolkit has them."""
        with raw_mode(0):
            raw = termios.tcgetattr(0)
        self._set(raw)

    @staticmethod
    def _set(attrs: list[Any]) -> None:
        with contextlib.suppress(termios.error):  # the window was closed
            termios.tcsetattr(0, termios.TCSANOW, attrs)
