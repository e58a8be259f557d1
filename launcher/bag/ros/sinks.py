"""Where recorded messages go: into files by a thread, or into a ring in memory."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace

from launcher.bag.bag_model import BagError, Message, Qos, Topic
from launcher.bag.writer import BagWriter, LastMessages

FLUSH_S = 1.0  # at most so much is lost if the recorder is killed


class FileSink:
    """Writes in a separate thread, so that a slow disk does not hold up the taking.

    At most `max_bytes` wait to be written, and what came within `max_s`. `error` is what ended the
    writing: a full disk.
    """

    def __init__(self, writer: BagWriter, max_bytes: int, max_s: float | None = None) -> None:
        self._writer = writer
        self._max_bytes = max_bytes
        self._max_ns = None if max_s is None else round(max_s * 1e9)
        self._queue: deque[Message | Callable[[], None]] = deque()
        self._waiting = 0
        self._next_ns: int | None = None  # the time of the message that is written next
        self._changed = threading.Condition()
        self._closed = False
        self.error: OSError | None = None
        self.is_whole = True
        self.written_bytes = 0
        self._thread = threading.Thread(target=self._run, name="bag writer", daemon=True)
        self._thread.start()

    def add_topic(self, topic: Topic) -> None:
        self._order(lambda: self._writer.add_topic(topic))

    def set_qos(self, topic: str, profiles: list[Qos]) -> None:
        self._order(lambda: self._writer.set_qos(topic, profiles))

    def repeat(self, topic: str, depth: int) -> None:
        self._order(lambda: self._writer.repeat(topic, depth))

    def split(self) -> None:
        """Begin a new file behind the messages that are waiting."""
        self._order(self._writer.split)
        self.wake()

    def _order(self, order: Callable[[], None]) -> None:
        self._queue.append(order)

    def put(self, message: Message, publisher: bytes) -> bool:
        """Take a message without waiting; False if there is no room for it."""
        size = len(message.data)
        if self._waiting and self._waiting + size > self._max_bytes:
            return False
        with self._changed:
            if self._next_ns is None:
                self._next_ns = message.log_ns
            elif self._max_ns is not None and message.log_ns - self._next_ns > self._max_ns:
                return False
            self._waiting += size
            self._queue.append(message)
        return True

    def wake(self) -> None:
        """Call after a burst of messages."""
        with self._changed:
            self._changed.notify()

    def _run(self) -> None:
        next_flush_s, fresh = time.monotonic() + FLUSH_S, False
        try:
            while True:
                with self._changed:
                    self._changed.wait_for(lambda: self._queue or self._closed, FLUSH_S)
                    if not self._queue and self._closed:
                        return
                fresh = self._write_all() or fresh
                if fresh and time.monotonic() >= next_flush_s:
                    self._writer.flush()
                    next_flush_s, fresh = time.monotonic() + FLUSH_S, False
                    self.written_bytes = self._writer.size_bytes
        except OSError as error:
            self.error = error

    def _write_all(self) -> bool:
        """Write what is in the queue; whether there were messages."""
        found = False
        while self._queue:
            one = self._queue.popleft()
            if not isinstance(one, Message):
                one()
                continue
            self._writer.write(one)
            found = True
            with self._changed:
                self._waiting -= len(one.data)
                following = self._queue[0] if self._queue else None
                self._next_ns = following.log_ns if isinstance(following, Message) else None
        return found

    def finish(self) -> OSError | None:
        """Write what waits and finish the bag; what ended the writing, if anything did.

        Then `is_whole` says whether a whole bag could be made of what had been written.
        """
        with self._changed:
            self._closed = True
            self._changed.notify()
        self._thread.join()
        if self.error is None:
            try:
                self._writer.close()
            except OSError as error:
                self.error = error
        if self.error is not None:
            try:
                self._writer.rescue()
            except (OSError, BagError):
                self.is_whole = False
        return self.error


class Ring:
    """Keeps the last messages in memory, up to `max_bytes` and `keep_s` (None: any age).

    `clock_ns` is the time against which ages are measured; None: that of the newest message.
    """

    def __init__(
        self,
        max_bytes: int,
        keep_s: float | None = None,
        clock_ns: Callable[[], int] | None = time.time_ns,
    ) -> None:
        self._max_bytes = max_bytes
        self._keep_ns = None if keep_s is None else round(keep_s * 1e9)
        self._clock_ns = clock_ns
        self._bytes = 0
        self._messages: deque[tuple[Message, bytes]] = deque()
        self._latched = LastMessages()
        self.topics: dict[str, Topic] = {}
        self.dropped_ns: int | None = None  # time of the newest message that room was lacking for

    def add_topic(self, topic: Topic) -> None:
        self.topics[topic.name] = topic

    def set_qos(self, topic: str, profiles: list[Qos]) -> None:
        self.topics[topic] = replace(self.topics[topic], qos=profiles)

    def repeat(self, topic: str, depth: int) -> None:
        """Begin all contents with the last messages of a topic."""
        self._latched.keep(topic, depth)

    def put(self, message: Message, publisher: bytes) -> bool:
        self._latched.add(message)
        self._messages.append((message, publisher))
        self._bytes += _size(message)
        while self._bytes > self._max_bytes and self._messages:
            self.dropped_ns = self._drop().log_ns
        return True

    def forget_old(self) -> None:
        """Drop what is older than the time to keep. Call it regularly."""
        if self._keep_ns is None or not self._messages:
            return
        now_ns = self._messages[-1][0].log_ns if self._clock_ns is None else self._clock_ns()
        oldest = now_ns - self._keep_ns
        while self._messages and self._messages[0][0].log_ns < oldest:
            self._drop()

    def _drop(self) -> Message:
        message, _ = self._messages.popleft()
        self._bytes -= _size(message)
        return message

    def contents(self) -> list[tuple[Message, bytes]]:
        """The messages with their publishers, oldest first; repeated ones at the first time."""
        found = sorted(self._messages, key=lambda one: one[0].log_ns)
        if not found:
            return []
        start, _ = found[0]
        again = [
            (one._replace(log_ns=start.log_ns, publish_ns=start.publish_ns), b"")
            for one in self._latched.before(start.log_ns)
        ]
        return [*again, *found]

    def clear(self) -> None:
        self._messages.clear()
        self._bytes = 0


_OVERHEAD_BYTES = 250  # of the objects of a message in memory, besides its data


def _size(message: Message) -> int:
    return len(message.data) + _OVERHEAD_BYTES
