"""Timers by name."""

from __future__ import annotations

from collections.abc import Callable

from launcher.posix.reactor import Reactor, Timer


class Timers:
    """A new timer of a name replaces the one before."""

    def __init__(self, reactor: Reactor) -> None:
        self._reactor = reactor
        self._timers: dict[str, Timer] = {}

    def __contains__(self, name: str) -> bool:
        return name in self._timers

    def after(self, name: str, delay_s: float, callback: Callable[[], object]) -> None:
        self.cancel(name)

        def fire() -> None:
            del self._timers[name]
            callback()

        self._timers[name] = self._reactor.call_later(delay_s, fire)

    def every(self, name: str, period_s: float, callback: Callable[[], object]) -> None:
        def fire() -> None:
            self.after(name, period_s, fire)
            callback()

        self.after(name, period_s, fire)

    def cancel(self, name: str) -> None:
        if name in self._timers:
            self._timers.pop(name).cancel()

    def close(self) -> None:
        for timer in self._timers.values():
            timer.cancel()
        self._timers.clear()
