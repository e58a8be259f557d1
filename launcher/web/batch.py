"""What comes in quick succession, passed on together."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class Batch(Generic[T]):
    """Calls `send` with what has been added, `within_s` of the first of it."""

    def __init__(self, within_s: float, send: Callable[[list[T]], object]) -> None:
        self._within_s = within_s
        self._send = send
        self._items: list[T] = []
        self._timer: asyncio.TimerHandle | None = None

    def add(self, item: T) -> None:
        """In the event loop."""
        self._items.append(item)
        if self._timer is None:
            self._timer = asyncio.get_running_loop().call_later(self._within_s, self.flush)

    def flush(self) -> None:
        """Pass it on now, if there is something."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        items, self._items = self._items, []
        if items:
            self._send(items)
