"""Turns: what one client wants done with the same process is done in the order of its requests."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from launcher.engine.posix.reactor import Reactor


class Turns:
    """One for a connection. Whoever has had its turn with a process says so with `over`.

    What waits is bounded by the requests that a connection may have without an answer.
    """

    def __init__(self, reactor: Reactor) -> None:
        self._reactor = reactor
        self._busy: dict[str, int] = {}
        self._waiting: dict[str, deque[Callable[[], None]]] = {}

    def take(self, process: str, do: Callable[[], None], *, helps: bool) -> None:
        """Do it now, or when what came before has happened to this process.

        `helps` what is being done now: it is not kept waiting by that.
        """
        if process in self._busy and (process in self._waiting or not helps):
            self._waiting.setdefault(process, deque()).append(do)
            return
        self._busy[process] = self._busy.get(process, 0) + 1
        do()

    def over(self, process: str) -> None:
        """It has happened: the next one may."""
        self._busy[process] -= 1
        if self._busy[process]:
            return
        del self._busy[process]
        waiting = self._waiting.get(process)
        if waiting is None:
            return
        self._busy[process] = 1
        self._reactor.call_later(0, waiting.popleft())
        if not waiting:
            del self._waiting[process]
