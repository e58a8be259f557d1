"""Messages between the operator and a host: JSON with its length in front, and contents of files.

A content is a row of blocks with their lengths, the last one empty; it may be compressed.
"""

from __future__ import annotations

import json
import struct
import zlib

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from typing import Any, BinaryIO, Protocol

    class Source(Protocol):
        def read(self, size: int, /) -> bytes: ...


READY = b"launcher-sync-ready\n"  # a login shell may print other lines before it
MAX_MESSAGE_BYTES = 256 * 1024 * 1024
BLOCK_BYTES = 256 * 1024
_LENGTH = struct.Struct(">I")


class Closed(Exception):
    """The other side has gone."""


def send(file: BinaryIO, message: dict[str, Any]) -> None:
    data = json.dumps(message).encode("ascii")
    file.write(_LENGTH.pack(len(data)) + data)
    file.flush()


def receive(file: Source) -> dict[str, Any]:
    """The next message; Closed."""
    length = _length(file)
    if length > MAX_MESSAGE_BYTES:
        raise Closed("what was received is no message")
    found: dict[str, Any] = json.loads(_exactly(file, length))
    return found


def send_content(
    file: BinaryIO, blocks: Iterable[bytes], *, compress: bool, count: Callable[[int], None]
) -> None:
    """Send the content of a file; `count` is called with the size of each block on its way."""
    packer = zlib.compressobj(1) if compress else None
    for block in blocks:
        _send_block(file, packer.compress(block) if packer else block, count)
    _send_block(file, packer.flush() if packer else b"", count)
    file.write(_LENGTH.pack(0))


def receive_content(file: Source, *, compress: bool) -> Iterator[bytes]:
    """The blocks of a content; Closed."""
    unpacker = zlib.decompressobj() if compress else None
    while length := _length(file):
        block = _exactly(file, length)
        yield unpacker.decompress(block) if unpacker else block


def _send_block(file: BinaryIO, block: bytes, count: Callable[[int], None]) -> None:
    if block:
        file.write(_LENGTH.pack(len(block)))
        file.write(block)
        count(len(block))


def _length(file: Source) -> int:
    found: int = _LENGTH.unpack(_exactly(file, _LENGTH.size))[0]
    return found


def _exactly(file: Source, size: int) -> bytes:
    data = file.read(size)
    if len(data) < size:
        raise Closed("the connection was closed")
    return data
