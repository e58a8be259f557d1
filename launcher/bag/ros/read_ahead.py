"""Reads messages of bags in a thread, some time before they are played."""

from __future__ import annotations

import heapq
import threading
from collections import deque
from collections.abc import Iterator, Sequence

from launcher.bag.bag_model import Message, Span
from launcher.bag.reader import Bag


class ReadAhead:
    """The messages of bags in the order of their times; at most `limit` are waiting.

    `peek` and `pop` raise the error of the reading.
    """

    def __init__(
        self, bags: Sequence[Bag], topics: Sequence[frozenset[str]], span: Span, limit: int
    ) -> None:
        self._bags = bags
        self._topics = topics
        self._limit = limit
        self._queue: deque[Message] = deque()
        self._error: Exception | None = None
        self._changed = threading.Condition()
        self._done = self._closed = False
        self._thread = threading.Thread(target=self._read, args=(span,), daemon=True)
        self._thread.start()

    def _messages(self, span: Span) -> Iterator[Message]:
        streams = [
            bag.messages(topics, span, lambda: self._closed)
            for bag, topics in zip(self._bags, self._topics, strict=True)
        ]
        if len(streams) == 1:
            return streams[0]
        return heapq.merge(*streams, key=lambda message: message.log_ns)

    def _read(self, span: Span) -> None:
        try:
            for message in self._messages(span):
                with self._changed:
                    while len(self._queue) >= self._limit and not self._closed:
                        self._changed.wait()
                    if self._closed:
                        return
                    self._queue.append(message)
                    self._changed.notify()
        except Exception as error:  # raised again in the thread that plays
            self._error = error
        finally:
            with self._changed:
                self._done = True
                self._changed.notify()

    def peek(self) -> Message | None:
        """The next message; None at the end."""
        with self._changed:
            while not self._queue and not self._done:
                self._changed.wait()
        if self._queue:
            return self._queue[0]
        if self._error is not None:
            raise self._error
        return None

    def pop(self) -> None:
        """Drop the message that `peek` returned."""
        with self._changed:
            self._queue.popleft()
            if len(self._queue) < self._limit // 2 + 1:
                self._changed.notify()

    def close(self) -> None:
        with self._changed:
            self._closed = True
            self._changed.notify()
        self._thread.join()
