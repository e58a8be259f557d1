"""A thread that takes messages from subscriptions as soon as they arrive, without decoding them.

It waits for all of them at once, and takes bursts: rclpy's executor would build and search a wait
set, in Python, for each message.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rclpy.impl.implementation_singleton import rclpy_implementation

from launcher.ros.discovery.observer import Observer
from launcher.ros.topics.raw import RawMessage, RawTaker

if TYPE_CHECKING:
    from rclpy.subscription import Subscription

_BURST = 1000
_WAIT_NS = -1  # for ever: the guard condition wakes it

Deliver = Callable[[int, bytes], None]  # time in ns, message in CDR
Take = Callable[[RawMessage], None]


class Receiver:
    """Subscriptions and what their messages are given to; close it before the observer."""

    def __init__(self, observer: Observer) -> None:
        self._context = observer.context
        self._guard = observer.node.create_guard_condition(lambda: None)
        self._lock = threading.Lock()
        self._entries: tuple[tuple[Any, Take], ...] = ()
        self._is_closed = False
        self._taker = RawTaker()
        self._thread = threading.Thread(target=self._run, name="receiver", daemon=True)
        self._thread.start()

    def add(self, subscription: Subscription, deliver: Take) -> None:
        """`deliver` is called in the thread of the receiver."""
        with self._lock:
            self._entries = (*self._entries, (subscription, deliver))
        self._guard.trigger()

    def remove(self, subscription: Subscription) -> None:
        """It may be destroyed afterwards."""
        with self._lock:
            self._entries = tuple(entry for entry in self._entries if entry[0] is not subscription)
        self._guard.trigger()

    def close(self) -> None:
        self._is_closed = True
        self._guard.trigger()
        self._thread.join()
        self._taker.close()

    def _run(self) -> None:
        while not self._is_closed:
            entries = self._entries
            for subscription, deliver in self._ready(entries):
                self._take(subscription, deliver)

    def _ready(self, entries: tuple[tuple[Any, Take], ...]) -> list[tuple[Any, Take]]:
        """Wait until one of them has messages, or the entries have changed."""
        with contextlib.ExitStack() as stack:
            held = [entry for entry in entries if self._hold(stack, entry[0])]
            stack.enter_context(self._context.handle)
            stack.enter_context(self._guard.handle)
            wait_set = rclpy_implementation.WaitSet(len(held), 1, 0, 0, 0, 0, self._context.handle)
            wait_set.clear_entities()
            for subscription, _ in held:
                wait_set.add_subscription(subscription.handle)
            wait_set.add_guard_condition(self._guard.handle)
            wait_set.wait(_WAIT_NS)
            ready = set(wait_set.get_ready_entities("subscription"))
            return [entry for entry in held if entry[0].handle.pointer in ready]

    @staticmethod
    def _hold(stack: contextlib.ExitStack, subscription: Subscription) -> bool:
        """Whether it still exists; it does then until the stack ends."""
        try:
            stack.enter_context(subscription.handle)
        except rclpy_implementation.InvalidHandle:
            return False
        return True

    def _take(self, subscription: Subscription, deliver: Take) -> None:
        handle = subscription.handle
        with contextlib.suppress(rclpy_implementation.InvalidHandle), handle:
            for _ in range(_BURST):
                if (raw := self._taker.take(handle)) is None:
                    return
                deliver(raw)
