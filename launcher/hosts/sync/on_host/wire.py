"""Messages between the operator and a host: JSON with its length in front, and contents of files.

A content is a row of blocks with their lengths, the last one empty. Those that get smaller by it
are compressed, each for itself.
"""

from __future__ import annotations

import json
import struct
import zlib

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from typing import Any, BinaryIO, Protocol

    class ContentSource(Protocol):
        def read(self, size: int, /) -> bytes: ...


READY = b"launcher-sync-ready\n"  # a login shell may print other lines before it
MAX_MESSAGE_BYTES = 256 * 1024 * 1024
BLOCK_BYTES = 256 * 1024
_LENGTH = struct.Struct(">I")
_COMPRESSED = 1 << 31  # in the length of a block
_LEAST_BYTES = 512  # of a block that is worth compressing
_SAMPLE_BYTES = 8 * 1024
_WORTH = 0.9  # of its size


class Closed(Exception):
    """The other side has gone."""


def send(file: BinaryIO, message: dict[str, Any]) -> None:
    data = json.dumps(message).encode("ascii")
    file.write(_LENGTH.pack(len(data)) + data)
    file.flush()


def receive(file: ContentSource) -> dict[str, Any]:
    """The next message; Closed."""
    length = _length(file)
    if length > MAX_MESSAGE_BYTES:
        raise Closed("what was received is no message")
    try:
        found: dict[str, Any] = json.loads(_exactly(file, length))
    except (ValueError, RecursionError):
        raise Closed("what was received is no message") from None
    return found


def send_content(file: BinaryIO, blocks: Iterable[bytes], count: Callable[[int], None]) -> None:
    """Send the content of a file; `count` is called with the size of each block on its way."""
    for block in blocks:
        packed = zlib.compress(block, 1) if _gets_smaller(block) else block
        flag = _COMPRESSED if packed is not block else 0
        file.write(_LENGTH.pack(len(packed) | flag))
        file.write(packed)
        count(len(packed))
    file.write(_LENGTH.pack(0))


def receive_content(file: ContentSource) -> Iterator[bytes]:
    """The blocks of a content; Closed."""
    while length := _length(file):
        block = _exactly(file, length & ~_COMPRESSED)
        yield _unpacked(block) if length & _COMPRESSED else block


def _unpacked(block: bytes) -> bytes:
    """Closed for what no sender packs."""
    unpacking = zlib.decompressobj()
    try:
        found = unpacking.decompress(block, MAX_MESSAGE_BYTES)
    except zlib.error:
        raise Closed("what was received is no content") from None
    if not unpacking.eof:
        raise Closed("what was received is no content")
    return found


def _gets_smaller(block: bytes) -> bool:
    """Whether compressing is worth its time: parts of archives and images stay as large."""
    sample = block[:_SAMPLE_BYTES]
    return len(sample) >= _LEAST_BYTES and len(zlib.compress(sample, 1)) < _WORTH * len(sample)


def _length(file: ContentSource) -> int:
    found: int = _LENGTH.unpack(_exactly(file, _LENGTH.size))[0]
    return found


def _exactly(file: ContentSource, size: int) -> bytes:
    data = file.read(size)
    if len(data) < size:
        raise Closed("the connection was closed")
    return data
