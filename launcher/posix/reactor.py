"""An event loop for file descriptors, timers and signals.

asyncio would do the same; importing it takes longer than starting the first process
(docs/inside/architecture.md has the numbers).
"""

from __future__ import annotations

import itertools
import os
import select
import signal
import time
from collections import deque
from collections.abc import Callable, Iterable
from types import FrameType, ModuleType

from launcher.posix import dispositions

Callback = Callable[[], object]


IDLE_WITHIN_S = 0.05  # what waits for an idle moment is done by then


class Timer:
    """One call in the future; `cancel()` is idempotent."""

    __slots__ = ("callback", "when")

    def __init__(self, when: float, callback: Callback) -> None:
        self.when = when
        self.callback: Callback | None = callback

    def cancel(self) -> None:
        self.callback = None


class Reactor:
    """epoll, a heap of timers and a wake-up pipe for signals. Close it, or use `with`."""

    def __init__(self) -> None:
        self._epoll = select.epoll()
        self._callbacks: dict[int, Callback] = {}
        self._timers: list[tuple[float, int, Timer]] = []
        self._heap: ModuleType | None = None
        self._when_idle: deque[tuple[float, Callback]] = deque()
        self._order = itertools.count()
        self._stopped = False
        self._handlers: dict[int, Callable[[int], None]] = {}
        self._before: dict[int, Callable[[int, FrameType | None], object] | int | None] = {}
        self._wakeup: tuple[int, int] | None = None
        self._wakeup_before = -1

    def __enter__(self) -> Reactor:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    # Seconds on the monotonic clock, the only one that deadlines are made of.
    now = staticmethod(time.monotonic)

    # ---- registration

    def add_reader(self, fd: int, callback: Callback) -> None:
        self._add(fd, select.EPOLLIN, callback)

    def add_writer(self, fd: int, callback: Callback) -> None:
        self._add(fd, select.EPOLLOUT, callback)

    def _add(self, fd: int, events: int, callback: Callback) -> None:
        self._epoll.register(fd, events)
        self._callbacks[fd] = callback

    def remove(self, fd: int) -> None:
        """Stop watching `fd`; no error if it is not watched."""
        if self._callbacks.pop(fd, None) is not None:
            try:
                self._epoll.unregister(fd)
            except OSError:
                return  # closed before it was removed

    def call_later(self, delay_s: float, callback: Callback) -> Timer:
        """Call back once, `delay_s` seconds from now; in the next pass of the loop if it is 0."""
        return self.call_at(self.now() + delay_s, callback)

    def call_at(self, when_s: float, callback: Callback) -> Timer:
        """Call back once, at this time; in the next pass of the loop if it has passed."""
        timer = Timer(when_s, callback)
        if self._heap is None:
            import heapq  # a shared library, loaded only after the first process was started

            self._heap = heapq
        self._heap.heappush(self._timers, (timer.when, next(self._order), timer))
        return timer

    def when_idle(self, callback: Callback) -> None:
        """Call back once, when nothing else is to be done, or soon if that does not happen.

        One in each pass: what takes milliseconds in total, as imports do, delays nothing by more
        than its longest part.
        """
        self._when_idle.append((self.now() + IDLE_WITHIN_S, callback))

    def on_signals(self, signums: Iterable[int], callback: Callable[[int], None]) -> None:
        """Call back, outside of signal context, when one of these signals arrives.

        What `dispositions` respects is left as it is. Nothing in another thread than the main one,
        which gets all signals.
        """
        if self._wakeup is None:
            read_end, write_end = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
            try:
                self._wakeup_before = signal.set_wakeup_fd(write_end, warn_on_full_buffer=False)
            except ValueError:
                os.close(read_end)
                os.close(write_end)
                return
            self._wakeup = (read_end, write_end)
            self.add_reader(read_end, self._deliver_signals)
        for signum in dispositions.heeded(signums):
            self._handlers[signum] = callback
            self._before[signum] = signal.signal(signum, _noted)

    def _deliver_signals(self) -> None:
        assert self._wakeup is not None
        for signum in os.read(self._wakeup[0], 512):
            handler = self._handlers.get(signum)
            if handler is not None:
                handler(signum)
            elif self._wakeup_before >= 0:
                os.write(self._wakeup_before, bytes([signum]))  # an asyncio loop around this one

    def take_signals(self) -> bytes:
        """The numbers of signals that have arrived and were not delivered; after `run`."""
        if self._wakeup is None:
            return b""
        try:
            return os.read(self._wakeup[0], 512)
        except BlockingIOError:
            return b""

    # ---- running

    def run(self) -> None:
        """Serve until `stop()` is called; not at all if it was called before."""
        while not self._stopped:
            self._turn(self.timeout_s())

    def _turn(self, timeout_s: float | None) -> None:
        callbacks = self._callbacks
        ready = self._epoll.poll(timeout_s)
        for fd, callback in [(fd, callbacks.get(fd)) for fd, _ in ready]:
            # An earlier callback of this pass may have removed this one, or closed the file
            # and opened another with the same number.
            if callback is not None and callbacks.get(fd) is callback:
                callback()
        has_fired = self._fire_timers()
        if self._when_idle and not self._stopped:
            is_idle = not (ready or has_fired)
            if is_idle or self._when_idle[0][0] < self.now():
                self._when_idle.popleft()[1]()

    # ---- within another loop: turn when `fileno()` is readable, and after `timeout_s()`

    def fileno(self) -> int:
        return self._epoll.fileno()

    def turn(self) -> bool:
        """One pass without waiting; False after `stop()`."""
        if not self._stopped:
            self._turn(0)
        return not self._stopped

    def stop(self) -> None:
        """Let `run()` return after the current pass."""
        self._stopped = True

    def timeout_s(self) -> float | None:
        """Seconds to the next timer, or 0 if a call waits for an idle moment; None without any."""
        if self._when_idle:
            return 0.0
        while self._timers and self._timers[0][2].callback is None:
            self._take_first()
        if not self._timers:
            return None
        return max(0.0, self._timers[0][0] - self.now())

    def _fire_timers(self) -> bool:
        """Call back those that are due; whether there was one."""
        now = self.now()
        has_fired = False
        while self._timers and self._timers[0][0] <= now:
            callback = self._take_first().callback
            if callback is not None:
                has_fired = True
                callback()
        return has_fired

    def _take_first(self) -> Timer:
        assert self._heap is not None
        timer: Timer = self._heap.heappop(self._timers)[2]
        return timer

    def close(self) -> None:
        """Restore the signal handlers and close all descriptors."""
        for signum, before in self._before.items():
            signal.signal(signum, signal.SIG_DFL if before is None else before)
        self._before.clear()
        if self._wakeup is not None:
            signal.set_wakeup_fd(self._wakeup_before)
            for fd in self._wakeup:
                os.close(fd)
            self._wakeup = None
        self._epoll.close()


def _noted(signum: int, frame: FrameType | None) -> None:
    """Does nothing: Python has already written the number to the wake-up pipe."""
