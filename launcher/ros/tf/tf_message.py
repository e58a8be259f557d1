"""Reads serialized `tf2_msgs/msg/TFMessage`, without the type: bags need not have it installed."""

from __future__ import annotations

import struct
from typing import Any

from launcher.ros.tf.arithmetic import Transform
from launcher.ros.tf.frame_buffer import StampedTransform

TYPE = "tf2_msgs/msg/TFMessage"
TOPICS = ("/tf", "/tf_static")
_HEAD_BYTES = 4


def read(data: bytes) -> list[StampedTransform]:
    """The transforms, without the slash that names of tf began with; ValueError."""
    try:
        return _Reader(data).transforms()
    except (struct.error, UnicodeDecodeError) as error:
        raise ValueError(f"a message is not a {TYPE}: {error}") from None


class _Reader:
    def __init__(self, data: bytes) -> None:
        self._data = data
        self._offset = _HEAD_BYTES
        self._order = "<" if data[1:2] == b"\x01" else ">"

    def transforms(self) -> list[StampedTransform]:
        (count,) = self._take("I", 4)
        return [self._transform() for _ in range(count)]

    def _transform(self) -> StampedTransform:
        sec, nanosec = self._take("iI", 4)
        parent, child = self._frame(), self._frame()
        x, y, z, *rotation = self._take("7d", 8)
        qx, qy, qz, qw = rotation
        transform = Transform((x, y, z), (qx, qy, qz, qw))
        return StampedTransform(parent, child, sec * 1_000_000_000 + nanosec, transform)

    def _frame(self) -> str:
        (length,) = self._take("I", 4)
        (text,) = self._take(f"{length}s", 1)
        return str(text.rstrip(b"\0").decode()).removeprefix("/")

    def _take(self, letters: str, alignment: int) -> tuple[Any, ...]:
        """The values of these letters of `struct`, each of which is aligned."""
        place = self._offset + (_HEAD_BYTES - self._offset) % alignment
        found = struct.unpack_from(self._order + letters, self._data, place)
        self._offset = place + struct.calcsize(self._order + letters)
        return found
