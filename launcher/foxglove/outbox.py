"""What waits to be sent to one client: bounded, since a client may read slowly or not at all."""

from __future__ import annotations

import threading
from collections import deque

from launcher.foxglove import protocol

CONTROL_BYTES = 64 * 1024 * 1024  # of messages that must not be lost; after it the client is lost


class Outbox:
    """Data of topics is dropped where it does not fit, the oldest first; all else is kept.

    Any thread may put something in; one takes it out. `put...` says whether that one has to be
    woken up, which it has not while it is still busy.
    """

    def __init__(self, most_bytes: int) -> None:
        self._most_bytes = most_bytes
        self._lock = threading.Lock()
        self._control: deque[str | bytes] = deque()
        self._control_bytes = 0
        self._data: deque[tuple[int, int, bytes]] = deque()  # subscription, time, message
        self._data_bytes = 0
        self._dropped = 0
        self._is_idle = True

    @property
    def is_overfull(self) -> bool:
        """Whether even what must not be lost has become too much."""
        return self._control_bytes > CONTROL_BYTES

    def put(self, message: str | bytes) -> bool:
        """A message that must not be lost; it overtakes data of topics."""
        with self._lock:
            if not self.is_overfull:
                self._control.append(message)
                self._control_bytes += len(message)
            return self._wakes()

    def put_data(self, subscription: int, time_ns: int, payload: bytes) -> bool:
        """A message of a topic. One that is larger than the bound is sent if it is alone."""
        with self._lock:
            self._data.append((subscription, time_ns, payload))
            self._data_bytes += len(payload)
            while self._data_bytes > self._most_bytes and len(self._data) > 1:
                self._data_bytes -= len(self._data.popleft()[2])
                self._dropped += 1
            return self._wakes()

    def forget(self, subscription: int) -> None:
        """Remove the data of a subscription that has ended."""
        with self._lock:
            self._data = deque(item for item in self._data if item[0] != subscription)
            self._data_bytes = sum(len(item[2]) for item in self._data)

    def take(self) -> str | bytes | None:
        """The next message to send; None if there is none, and then the next put wakes."""
        with self._lock:
            if self._control:
                message = self._control.popleft()
                self._control_bytes -= len(message)
                return message
            if self._data:
                subscription, time_ns, payload = self._data.popleft()
                self._data_bytes -= len(payload)
                return protocol.message_data(subscription, time_ns, payload)
            self._is_idle = True
            return None

    def take_dropped(self) -> int:
        """How many messages were dropped since the last call."""
        with self._lock:
            dropped, self._dropped = self._dropped, 0
            return dropped

    def _wakes(self) -> bool:
        wakes, self._is_idle = self._is_idle, False
        return wakes
