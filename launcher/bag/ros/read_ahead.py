"""Reads messages of bags in a thread, some time before they are played."""

from __future__ import annotations

import heapq
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence

from launcher.bag.bag_model import Message, Span, never
from launcher.bag.reader import Bag


def merged(
    bags: Sequence[Bag],
    topics: Sequence[frozenset[str]],
    span: Span,
    stopped: Callable[[], bool] = never,
) -> Iterator[Message]:
    """The messages of these topics of each bag, in the order in which they were received."""
    streams = [bag.messages(names, span, stopped) for bag, names in zip(bags, topics, strict=True)]
    if len(streams) == 1:
        return streams[0]
    return heapq.merge(*streams, key=lambda message: message.log_ns)


def by_sending(messages: Iterable[Message], limit: int) -> Iterator[Message]:
    """Messages in the order in which they were published, with this time as `log_ns`.

    Where one was received more than `limit` messages too late, it is out of order.
    """
    waiting: list[tuple[int, int, Message]] = []
    for number, one in enumerate(messages):
        sent_ns = one.publish_ns or one.log_ns
        heapq.heappush(waiting, (sent_ns, number, one._replace(log_ns=sent_ns)))
        if len(waiting) > limit:
            yield heapq.heappop(waiting)[2]
    while waiting:
        yield heapq.heappop(waiting)[2]


class ReadAhead:
    """The messages of bags in the order of their times; at most `limit` are waiting.

    With `sent` the times are those of publishing; then the bags are read from their start, since
    what was received early may have been published late by its clock. `peek` and `pop` raise the
    error of the reading.
    """

    def __init__(
        self,
        bags: Sequence[Bag],
        topics: Sequence[frozenset[str]],
        span: Span,
        limit: int,
        *,
        sent: bool = False,
    ) -> None:
        self._bags = bags
        self._topics = topics
        self._limit = limit
        self._sent = sent
        self._queue: deque[Message] = deque()
        self._error: Exception | None = None
        self._changed = threading.Condition()
        self._done = self._closed = False
        self._thread = threading.Thread(target=self._read, args=(span,), daemon=True)
        self._thread.start()

    def _messages(self, span: Span) -> Iterator[Message]:
        read = (self._bags, self._topics)
        if not self._sent:
            yield from merged(*read, span, lambda: self._closed)
            return
        start_ns = span.start_ns or 0
        for message in by_sending(merged(*read, Span(), lambda: self._closed), self._limit):
            if span.end_ns is not None and message.log_ns >= span.end_ns:
                return
            if message.log_ns >= start_ns:
                yield message

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
