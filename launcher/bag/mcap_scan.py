"""Reads an MCAP file from its beginning, as far as it is whole, and says what is wrong with it.

The format: https://mcap.dev/spec. A recorder that was killed leaves a file without the summary that
readers look for at the end, and perhaps with half a chunk.
"""

from __future__ import annotations

import contextlib
import io
import os
import struct
import sys
import zlib
from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import IO, Any

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import (
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    Footer,
    Header,
    Message,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)
from mcap.stream_reader import breakup_chunk

from launcher.bag.model import Extent

MAGIC = b"\x89MCAP0\r\n"
_HEAD = struct.Struct("<BQ")  # opcode and length of a record
_INDEX = struct.Struct("<HI")  # channel of a message index, and its length in bytes
_AFTER_DATA = (Opcode.DATA_END, Opcode.FOOTER)


@dataclass(frozen=True, slots=True)
class Fault:
    """What is wrong, and at which byte of the file. `lost` says whether data are."""

    offset: int
    text: str
    lost: bool = True


@dataclass(slots=True)
class Scan:
    """What a file has. `end` is the offset behind the last whole record of its data."""

    header: Header | None = None
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    chunks: list[ChunkIndex] = field(default_factory=list)
    metadata: list[MetadataIndex] = field(default_factory=list)
    attachments: list[AttachmentIndex] = field(default_factory=list)
    counts: dict[int, int] = field(default_factory=dict)
    extent: Extent = field(default_factory=Extent)
    statistics: Statistics | None = None
    custom: dict[str, dict[str, str]] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)
    end: int = 0
    finished: bool = False
    loose: int = 0  # messages outside of chunks
    chunk: ChunkIndex | None = None  # the one whose message indexes follow

    @property
    def only_unfinished(self) -> bool:
        """Whether only the end is missing, so that appending it makes the file whole."""
        return self.header is not None and not any(fault.lost for fault in self.faults)


class _Damage(Exception):
    """A record cannot be read."""


def scan(stream: IO[bytes]) -> Scan:
    """Read all of a file. OSError; faults of the contents are in the result."""
    found = Scan()
    size = stream.seek(0, os.SEEK_END)
    stream.seek(0)
    if size < len(MAGIC) and MAGIC.startswith(stream.read()):
        found.faults.append(Fault(0, "it is empty: its recorder was killed", lost=False))
        return found
    stream.seek(0)
    if stream.read(len(MAGIC)) != MAGIC:
        found.faults.append(Fault(0, "it is not an MCAP file"))
        return found
    found.end = len(MAGIC)
    stream.seek(0)
    _read_channels(stream, found)
    stream.seek(len(MAGIC))
    try:
        _read_data(stream, size, found)
        _read_summary(stream, size, found)
    except _Damage as damage:
        found.faults.append(Fault(found.end, str(damage), lost=False))
    return found


def _read_channels(stream: IO[bytes], found: Scan) -> None:
    """The channels as the summary has them, since the chunk that has them may be damaged."""
    with contextlib.suppress(Exception):  # there is no summary
        summary = SeekingReader(stream).get_summary()
        if summary is not None:
            found.schemas.update(summary.schemas)
            found.channels.update(summary.channels)


def _records(stream: IO[bytes], size: int) -> Iterator[tuple[int, int, bytes]]:
    """(offset, opcode, contents) of each record from here on; _Damage at a broken one."""
    while True:
        offset = stream.tell()
        if offset == size:
            raise _Damage("it ends without a summary: its recorder did not finish it")
        head = stream.read(_HEAD.size)
        if len(head) < _HEAD.size:
            raise _Damage(f"it ends within a record, after {offset} bytes")
        opcode, length = _HEAD.unpack(head)
        if length > size - offset - _HEAD.size:
            name = Opcode(opcode).name.lower() if opcode in set(Opcode) else "record"
            raise _Damage(f"it ends within a {name}, after {offset} bytes")
        yield offset, opcode, stream.read(length)


def _parse(kind: Any, contents: bytes) -> Any:
    stream = ReadDataStream(io.BytesIO(contents))
    try:
        return kind.read(stream, len(contents)) if kind is Message else kind.read(stream)
    except Exception as error:
        raise _Damage(f"a {kind.__name__.lower()} record is damaged ({error})") from None


def _read_data(stream: IO[bytes], size: int, found: Scan) -> None:
    for offset, opcode, contents in _records(stream, size):
        if opcode in _AFTER_DATA:
            stream.seek(offset)
            return
        try:
            _take(found, offset, opcode, contents)
        except _Damage as damage:
            found.faults.append(Fault(offset, str(damage)))
        found.end = offset + _HEAD.size + len(contents)


def _take(found: Scan, offset: int, opcode: int, contents: bytes) -> None:
    match opcode:
        case Opcode.HEADER:
            found.header = _parse(Header, contents)
        case Opcode.SCHEMA | Opcode.CHANNEL | Opcode.MESSAGE:
            found.loose += opcode == Opcode.MESSAGE
            kind = {Opcode.SCHEMA: Schema, Opcode.CHANNEL: Channel}.get(Opcode(opcode), Message)
            _count(found, _parse(kind, contents))
        case Opcode.CHUNK:
            _take_chunk(found, offset, _parse(Chunk, contents), len(contents))
        case Opcode.MESSAGE_INDEX:
            if (chunk := found.chunk) is not None:
                index = _parse(MessageIndex, contents)
                chunk.message_index_offsets[index.channel_id] = offset
                chunk.message_index_length += _HEAD.size + len(contents)
        case Opcode.METADATA:
            one = _parse(Metadata, contents)
            length = _HEAD.size + len(contents)
            found.metadata.append(MetadataIndex(offset=offset, length=length, name=one.name))
            found.custom[one.name] = one.metadata


def index_times(block: bytes) -> Iterator[tuple[int, array[int]]]:
    """(channel, times) of the message indexes behind a chunk; struct.error, ValueError."""
    offset = 0
    while offset < len(block):
        opcode, length = _HEAD.unpack_from(block, offset)
        offset += _HEAD.size
        if opcode == Opcode.MESSAGE_INDEX:
            channel_id, size = _INDEX.unpack_from(block, offset)
            start = offset + _INDEX.size
            pairs = array("q")  # of a time and a place in the chunk
            pairs.frombytes(block[start : start + size])
            if sys.byteorder == "big":
                pairs.byteswap()
            yield channel_id, pairs[::2]
        offset += length


def records_of(chunk: Chunk) -> list[Any]:
    """What is in a chunk; ValueError if it is damaged."""
    try:
        return list(breakup_chunk(chunk, validate_crc=True))
    except Exception as error:  # of the decompressor, of the checksum, of a record
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ValueError(reason) from None


def chunk_of(record: bytes) -> Any:
    """The chunk of a whole record."""
    return _parse(Chunk, record[_HEAD.size :])


def _take_chunk(found: Scan, offset: int, chunk: Chunk, length: int) -> None:
    found.chunk = None
    try:
        records = records_of(chunk)
    except ValueError as error:
        raise _Damage(f"a chunk is damaged ({error})") from None
    for record in records:
        _count(found, record)
    found.chunk = ChunkIndex(
        chunk_length=_HEAD.size + length,
        chunk_start_offset=offset,
        compression=chunk.compression,
        compressed_size=len(chunk.data),
        message_end_time=chunk.message_end_time,
        message_index_length=0,
        message_index_offsets={},
        message_start_time=chunk.message_start_time,
        uncompressed_size=chunk.uncompressed_size,
    )
    found.chunks.append(found.chunk)


def _count(found: Scan, record: Any) -> None:
    match record:
        case Schema():
            found.schemas[record.id] = record
        case Channel():
            found.channels[record.id] = record
        case Message():
            channel = found.channels.get(record.channel_id)
            if channel is None:
                raise _Damage(f"a message belongs to the unknown channel {record.channel_id}")
            found.counts[channel.id] = found.counts.get(channel.id, 0) + 1
            found.extent.add(channel.topic, record.log_time)


def _read_summary(stream: IO[bytes], size: int, found: Scan) -> None:
    for offset, opcode, contents in _records(stream, size):
        if opcode == Opcode.STATISTICS:
            found.statistics = _parse(Statistics, contents)
        if opcode == Opcode.FOOTER:
            _check_end(stream, offset, _parse(Footer, contents), found)
            return


def _check_end(stream: IO[bytes], offset: int, footer: Footer, found: Scan) -> None:
    if stream.read(len(MAGIC)) != MAGIC:
        raise _Damage("its last bytes are missing")
    if footer.summary_start and footer.summary_crc:
        stream.seek(footer.summary_start)
        covered = stream.read(offset + _HEAD.size + 16 - footer.summary_start)
        if zlib.crc32(covered) != footer.summary_crc:
            raise _Damage("its summary is damaged")
    told = found.statistics
    if told and not found.faults and told.message_count != found.extent.total:
        text = f"its summary counts {told.message_count} messages, it has {found.extent.total}"
        raise _Damage(text)
    found.finished = footer.summary_start != 0
    if not found.finished:
        raise _Damage("it has no summary")
