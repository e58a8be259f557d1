"""Messages of transforms, whose type no wheel has."""

from __future__ import annotations

import struct


def tf_message(*transforms: tuple) -> bytes:
    """A serialized `tf2_msgs/msg/TFMessage`: parent, child, stamp in ns, translation, rotation."""
    data = bytearray(struct.pack("<I", len(transforms)))

    def align(size: int) -> None:
        data.extend(bytes(-len(data) % size))

    for parent, child, stamp_ns, translation, rotation in transforms:
        align(4)
        data += struct.pack("<iI", *divmod(stamp_ns, 10**9))
        for text in (parent.encode() + b"\0", child.encode() + b"\0"):
            align(4)
            data += struct.pack("<I", len(text)) + text
        align(8)
        data += struct.pack("<7d", *translation, *rotation)
    return b"\0\1\0\0" + bytes(data)
