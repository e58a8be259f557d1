"""When messages came that nobody has asked for yet, and the stamps in them. Imports no rclpy."""

from __future__ import annotations

import struct
from array import array
from collections.abc import Mapping
from typing import Any

NANOS = 1_000_000_000
MOST = 5000  # of one subscription in one answer
NO_STAMP = -1

_STAMPED = ("std_msgs/Header", "builtin_interfaces/Time")
_HEADER_BYTES = 4  # of the encapsulation; its second byte is odd for little endian
_TIMES = (struct.Struct(">iI"), struct.Struct("<iI"))
_STAMP_END = _HEADER_BYTES + _TIMES[0].size


def has_stamp(fields: Mapping[str, str]) -> bool:
    """Whether the first of the fields of a type, as rclpy lists them, begins with a time."""
    return next(iter(fields.values()), "") in _STAMPED


def stamp_ns(message: bytes) -> int:
    """The time at the beginning of a serialized message, NO_STAMP if it is not set.

    The sender of a message whose time is 0 has left it out. The layout is that of CDR in both byte
    orders (OMG DDSI-RTPS 2.5, 10.2): `int32 sec` and `uint32 nanosec` after the encapsulation.
    """
    if len(message) < _STAMP_END:
        return NO_STAMP
    seconds, nanoseconds = _TIMES[message[1] & 1].unpack_from(message, _HEADER_BYTES)
    return seconds * NANOS + nanoseconds or NO_STAMP


class NewArrivals:
    """Three times of each message since the last `document`, of the newest MOST.

    In nanoseconds: received on the monotonic clock, sent and stamped in wall time.
    """

    def __init__(self) -> None:
        self._received_ns, self._sent_ns, self._stamps_ns = array("q"), array("q"), array("q")
        self._left_out = 0

    def __len__(self) -> int:
        return len(self._received_ns)

    def add(self, received_ns: int, sent_ns: int, stamp_ns: int = NO_STAMP) -> None:
        self._received_ns.append(received_ns)
        self._sent_ns.append(sent_ns)
        self._stamps_ns.append(stamp_ns)
        if len(self._received_ns) >= 2 * MOST:
            self._forget()

    def _forget(self) -> None:
        self._left_out += max(0, len(self._received_ns) - MOST)
        for times_ns in (self._received_ns, self._sent_ns, self._stamps_ns):
            del times_ns[:-MOST]

    def document(self, *, stamped: bool) -> dict[str, Any]:
        """What has arrived, which is forgotten then."""
        self._forget()
        received_ns, sent_ns, stamps_ns = self._received_ns, self._sent_ns, self._stamps_ns
        found = {
            "mono": [at_ns / NANOS for at_ns in received_ns],
            "sent": [at_ns / NANOS for at_ns in sent_ns],
            "stamp": [_seconds(at_ns) for at_ns in stamps_ns] if stamped else None,
            "left_out": self._left_out,
        }
        for times_ns in (received_ns, sent_ns, stamps_ns):
            del times_ns[:]
        self._left_out = 0
        return found


def _seconds(at_ns: int) -> float | None:
    return None if at_ns == NO_STAMP else at_ns / NANOS
