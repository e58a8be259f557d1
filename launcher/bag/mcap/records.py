"""Records of MCAP files (https://mcap.dev/spec), each of them read within its own bytes."""

from __future__ import annotations

import functools
import io
import os
import struct
import sys
import zlib
from array import array
from collections.abc import Iterable, Iterator
from typing import IO, Any, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    Message,
    Schema,
    Statistics,
)

from launcher.bag import compression
from launcher.bag.bag_model import LAST_NS

MAGIC = b"\x89MCAP0\r\n"
HEAD = struct.Struct("<BQ")  # opcode and length of a record
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
_CHUNK = struct.Struct("<QQQI")  # first time, last time, size, checksum
_INDEX = struct.Struct("<HI")  # channel of a message index, and its length in bytes
_LENGTH = struct.Struct("<I")
_LONG = struct.Struct("<Q")
_PIECE = 1 << 20
_POLYNOMIAL = 0xEDB88320  # of CRC-32, its lowest bit is that of x to the power of 31
_OPCODES = frozenset(Opcode)
_KINDS: dict[int, Any] = {Opcode.SCHEMA: Schema, Opcode.CHANNEL: Channel}
_TIMES = ("log_time", "publish_time", "message_start_time", "message_end_time")


class Damage(Exception):
    """A record, or a part of a file, cannot be read; the message is a sentence without a dot."""


class RecordPlace(NamedTuple):
    """Where a record is; `length` is that of its contents, behind the head."""

    offset: int
    opcode: int
    length: int

    @property
    def contents(self) -> int:
        return self.offset + HEAD.size

    @property
    def end(self) -> int:
        return self.contents + self.length

    @property
    def name(self) -> str:
        return name_of(self.opcode)


def name_of(opcode: int) -> str:
    return Opcode(opcode).name.lower().replace("_", " ") if opcode in _OPCODES else "record"


class RecordSource:
    """A file from `offset` on; with `has_crc`, the checksum of what has been read of it."""

    def __init__(self, stream: IO[bytes], offset: int = 0, *, has_crc: bool = True) -> None:
        self.size = stream.seek(0, os.SEEK_END)
        self.crc = 0
        self._has_crc = has_crc
        self._stream = stream
        self.seek(offset)

    @property
    def offset(self) -> int:
        return self._stream.tell()

    def seek(self, offset: int) -> None:
        """Damage if the file has no such place."""
        if not 0 <= offset <= self.size:
            raise Damage(f"it says that a record is at {offset}, and has {self.size} bytes")
        self._stream.seek(offset)

    def head(self) -> RecordPlace:
        """Of the record that follows; Damage if it does not end within the file."""
        offset = self.offset
        if offset == self.size:
            raise Damage("it ends without a summary: its recorder did not finish it")
        head = self.read(HEAD.size)
        if len(head) < HEAD.size:
            raise Damage(f"it ends within a record, after {offset} bytes")
        place = RecordPlace(offset, *HEAD.unpack(head))
        if place.end > self.size:
            raise Damage(f"it ends within a {place.name}, after {offset} bytes")
        return place

    def contents(self, place: RecordPlace) -> bytes:
        """Of the record whose head was read. Damage before a chunk of a wrong length is."""
        if place.opcode == Opcode.CHUNK:
            check_chunk_length(self.peek(place, 128), place.length)
        return self.read(place.length)

    def read(self, length: int) -> bytes:
        data = self._stream.read(length)
        if self._has_crc:
            self.crc = zlib.crc32(data, self.crc)
        return data

    def peek(self, place: RecordPlace, most: int) -> bytes:
        """What the contents of the record whose head was read begin with."""
        start = self._stream.read(min(place.length, most))
        self._stream.seek(place.contents)
        return start

    def resume(self, place: RecordPlace) -> None:
        """Behind a record that may have been read in part; its bytes count once."""
        if self._stream.tell() == place.contents:
            self.skip(place)
        else:
            self._stream.seek(place.end)

    def skip(self, place: RecordPlace) -> None:
        """Over the contents of the record whose head was read."""
        self._stream.seek(place.contents)
        for piece in pieces(self._stream, place.length):
            self.crc = zlib.crc32(piece, self.crc)


def pieces(stream: IO[bytes], length: int) -> Iterator[bytes]:
    """The bytes that follow in a file, so many or up to its end."""
    while length and (piece := stream.read(min(length, _PIECE))):
        length -= len(piece)
        yield piece


def checksum(stream: IO[bytes], start: int, end: int) -> int:
    """Of these bytes of a file."""
    stream.seek(start)
    crc = 0
    for piece in pieces(stream, end - start):
        crc = zlib.crc32(piece, crc)
    return crc


def joined_checksum(first: int, second: int, length: int) -> int:
    """The CRC-32 of two texts, one behind the other, from theirs; `length` is that of the second.

    The remainder of the first is multiplied by x to the power of the bits behind it, which takes
    40 us for a megabyte, and reading that again 250.
    """
    power = 3  # of 2: that many bits are a byte
    while length:
        if length & 1:
            first = _product(first, _power_of_x(power))
        length >>= 1
        power += 1
    return first ^ second


@functools.cache
def _power_of_x(power: int) -> int:
    """x to the power of 2 to the power of this, modulo the polynomial of CRC-32."""
    if power == 0:
        return 1 << 30
    root = _power_of_x(power - 1)
    return _product(root, root)


def _product(one: int, other: int) -> int:
    """Of two polynomials, modulo that of CRC-32. The highest bit is that of x to the power of 0."""
    found = 0
    for bit in range(31, -1, -1):
        if one >> bit & 1:
            found ^= other
        other = other >> 1 ^ (_POLYNOMIAL if other & 1 else 0)
    return found


def check_chunk_length(start: bytes, length: int) -> None:
    """Damage if what a chunk begins with says another length than the record does."""
    try:
        (name_length,) = _LENGTH.unpack_from(start, _CHUNK.size)
        before = _CHUNK.size + _LENGTH.size + name_length
        (data_length,) = _LONG.unpack_from(start, before)
    except struct.error:
        raise Damage("the head of a chunk is damaged") from None
    if before + _LONG.size + data_length != length:
        raise Damage("the head of a chunk is damaged")


class _Contents(ReadDataStream):  # type: ignore[misc]  # of an untyped library
    """Those of one record; reading beyond their end is an error."""

    def read(self, length: int) -> bytes:
        data: bytes = super().read(length)
        if len(data) < length:
            raise EndOfFile
        return data


def parse(kind: Any, contents: bytes) -> Any:
    """A record of the library's class `kind`; Damage."""
    name = kind.__name__
    stream = _Contents(io.BytesIO(contents))
    try:
        if kind is Message:
            return message_of(contents)
        record = kind.read(stream)
    except EndOfFile:
        raise Damage(f"a {name.lower()} record is damaged (it is too short)") from None
    except UnicodeDecodeError:
        raise Damage(f"a {name.lower()} record is damaged (a text is not UTF-8)") from None
    if kind in (Chunk, ChunkIndex, Statistics):
        check_times(record)
    return record


def check_times(record: object) -> None:
    """Damage if a record has a time after 2262, which ROS has no room for."""
    for name in _TIMES:
        if getattr(record, name, 0) > LAST_NS:
            raise Damage(f"a {type(record).__name__.lower()} has an impossible time")


def message_of(contents: bytes, begin: int = 0, end: int | None = None) -> Message:
    """The message in these bytes, or in a part of them. Damage."""
    end = len(contents) if end is None else end
    if end - begin < _MESSAGE.size:
        raise Damage("a message record is damaged (it is too short)")
    channel_id, sequence, log_ns, publish_ns = _MESSAGE.unpack_from(contents, begin)
    if log_ns > LAST_NS or publish_ns > LAST_NS:
        raise Damage("a message has an impossible time")
    return Message(
        channel_id=channel_id,
        log_time=log_ns,
        data=contents[begin + _MESSAGE.size : end],
        publish_time=publish_ns,
        sequence=sequence,
    )


def chunk_contents(chunk: Chunk) -> bytes:
    """The uncompressed contents of a chunk, of the size and with the checksum that it says.

    Damage.
    """
    try:
        data = compression.exactly(chunk.data, chunk.uncompressed_size, chunk.compression)
    except ValueError as error:
        raise Damage(str(error)) from None
    if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
        raise Damage("its checksum is wrong")
    return data


def records_in(data: bytes) -> Iterator[tuple[int, Any]]:
    """(offset, record) of the schemas, channels and messages in the contents of a chunk.

    Damage.
    """
    offset, end = 0, len(data)
    while offset < end:
        if end - offset < HEAD.size:
            raise Damage("it ends within a record")
        opcode, length = HEAD.unpack_from(data, offset)
        begin = offset + HEAD.size
        if length > end - begin:
            raise Damage(f"it ends within a {name_of(opcode)}")
        if opcode == Opcode.MESSAGE:
            yield offset, message_of(data, begin, begin + length)
        elif (kind := _KINDS.get(opcode)) is not None:
            yield offset, parse(kind, data[begin : begin + length])
        offset = begin + length


def message_indexes(records: Iterable[tuple[int, Any]]) -> dict[int, list[tuple[int, int]]]:
    """(time, offset) of the messages in a chunk, by their channels."""
    found: dict[int, list[tuple[int, int]]] = {}
    for offset, record in records:
        if isinstance(record, Message):
            found.setdefault(record.channel_id, []).append((record.log_time, offset))
    return found


def index_times(block: bytes) -> Iterator[tuple[int, array[int]]]:
    """(channel, times) of the message indexes behind a chunk; Damage."""
    offset = 0
    try:
        while offset < len(block):
            opcode, length = HEAD.unpack_from(block, offset)
            offset += HEAD.size
            if opcode == Opcode.MESSAGE_INDEX:
                channel_id, size = _INDEX.unpack_from(block, offset)
                start = offset + _INDEX.size
                pairs = array("q", block[start : start + size])
                if sys.byteorder == "big":
                    pairs.byteswap()
                times = pairs[::2]
                if min(times, default=0) < 0:
                    raise Damage("an index has an impossible time")
                yield channel_id, times
            offset += length
    except (struct.error, ValueError):
        raise Damage("an index is damaged") from None


def attachment_index(source: RecordSource, place: RecordPlace) -> AttachmentIndex:
    """Of the attachment whose head was read, without reading its data at once. Damage."""
    start = source.peek(place, 1 << 16)
    try:
        log_time, create_time = struct.unpack_from("<QQ", start)
        texts, at = [], 16
        for _ in range(2):
            (length,) = _LENGTH.unpack_from(start, at)
            at += _LENGTH.size
            texts.append(start[at : at + length].decode())
            at += length
        (size,) = _LONG.unpack_from(start, at)
    except (struct.error, UnicodeDecodeError):
        raise Damage("an attachment is damaged") from None
    if at + _LONG.size + size + _LENGTH.size != place.length:
        raise Damage("an attachment is damaged")
    source.skip(place)
    return AttachmentIndex(
        offset=place.offset,
        length=HEAD.size + place.length,
        log_time=log_time,
        create_time=create_time,
        data_size=size,
        name=texts[0],
        media_type=texts[1],
    )
