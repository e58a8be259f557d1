"""What the main thread is to do next: put by any thread, and by handlers of signals."""

from __future__ import annotations

import collections
import contextlib
import os
import select
import signal
from collections.abc import Callable

Task = Callable[[], None]


class Tasks:
    """Made and taken from in the main thread.

    A `SimpleQueue` can miss a signal: one that arrives just before the main thread sleeps on its
    lock runs its handler only after the next task, which may never come. This sleeps on a pipe,
    into which Python writes at each signal.
    """

    def __init__(self) -> None:
        self._tasks: collections.deque[Task] = collections.deque()
        self._reader, self._writer = os.pipe()
        os.set_blocking(self._reader, False)
        os.set_blocking(self._writer, False)
        self._poll = select.poll()
        self._poll.register(self._reader, select.POLLIN)
        signal.set_wakeup_fd(self._writer, warn_on_full_buffer=False)

    def put(self, task: Task) -> None:
        self._tasks.append(task)
        with contextlib.suppress(BlockingIOError):  # it is full, and wakes the main thread anyway
            os.write(self._writer, b"\0")

    def get(self, timeout_s: float | None = None) -> Task | None:
        """The next task; `None` if there is none for this time, or if a signal came in between."""
        if not self._tasks:
            self._poll.poll(None if timeout_s is None else timeout_s * 1000)
            with contextlib.suppress(BlockingIOError):
                os.read(self._reader, 4096)
        return self._tasks.popleft() if self._tasks else None
