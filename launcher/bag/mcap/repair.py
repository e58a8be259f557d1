"""Makes an MCAP file whole that was not finished, or that is damaged."""

from __future__ import annotations

import dataclasses
import os
import struct
import zlib
from collections.abc import Iterable
from typing import IO, Any

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    MessageIndex,
    Statistics,
    SummaryOffset,
)

from launcher.bag.bag_model import BagError, Extent
from launcher.bag.mcap.records import (
    HEAD,
    MAGIC,
    checksum,
    chunk_contents,
    message_indexes,
    parse,
    pieces,
    records_in,
)
from launcher.bag.mcap.scan import McapScan, scan
from launcher.bag.metadata import removed_after_error

PROFILE, LIBRARY = "ros2", "launcher"


def append_summary(path: str) -> Extent:
    """Cut off what is not whole at the end, and append the summary. OSError, BagError.

    It takes no room but that of the summary.
    """
    with open(path, "r+b") as stream:
        found = scan(stream)
        if found.header is None and not any(fault.lost for fault in found.faults):
            _write_empty(stream)  # the recorder was killed before it wrote anything
            found = scan(stream)
        if found.header is None:
            raise BagError(f"{path} is not an MCAP file")
        stream.truncate(found.end)
        stream.seek(found.end)
        _complete_indexes(stream, found)
        stream.write(summary_of(found))
        stream.flush()
        os.fsync(stream.fileno())
    return found.extent


def drop_chunks(path: str, number: int) -> bool:
    """Cut off this many of the last chunks, with what follows; False if there is none. OSError."""
    with open(path, "r+b") as stream:
        chunks = sorted(chunk.chunk_start_offset for chunk in scan(stream).chunks)
        if chunks:
            stream.truncate(chunks[-min(number, len(chunks))])
    return bool(chunks)


def _write_empty(stream: IO[bytes]) -> None:
    stream.truncate(0)
    stream.seek(0)
    head = RecordBuilder()
    Header(PROFILE, LIBRARY).write(head)
    stream.write(MAGIC + head.end())
    stream.flush()


def summary_of(found: McapScan) -> bytes:
    """The end of a file whose data end at `found.end`."""
    ending = RecordBuilder()
    DataEnd(found.crc).write(ending)
    data_end = ending.end()
    start = found.end + len(data_end)
    summary = RecordBuilder()
    groups = (
        (Opcode.SCHEMA, found.schemas.values()),
        (Opcode.CHANNEL, found.channels.values()),
        (Opcode.STATISTICS, [_statistics(found)]),
        (Opcode.CHUNK_INDEX, found.chunks),
        (Opcode.ATTACHMENT_INDEX, found.attachments),
        (Opcode.METADATA_INDEX, found.metadata),
    )
    offsets = [_group(summary, start, opcode, records) for opcode, records in groups]
    offsets_start = start + summary.count
    for offset in filter(None, offsets):
        offset.write(summary)
    contents = summary.end()
    head = struct.pack("<BQQQ", Opcode.FOOTER, 20, start, offsets_start)
    footer = RecordBuilder()
    Footer(
        summary_start=start,
        summary_offset_start=offsets_start,
        summary_crc=zlib.crc32(head, zlib.crc32(contents)),
    ).write(footer)
    return b"".join((data_end, contents, footer.end(), MAGIC))


def _group(
    summary: RecordBuilder, start: int, opcode: Opcode, records: Iterable[Any]
) -> SummaryOffset | None:
    before = summary.count
    for record in records:
        record.write(summary)
    if summary.count == before:
        return None
    return SummaryOffset(
        group_opcode=opcode, group_start=start + before, group_length=summary.count - before
    )


def _statistics(found: McapScan) -> Statistics:
    return Statistics(
        attachment_count=len(found.attachments),
        channel_count=len(found.channels),
        channel_message_counts=found.counts,
        chunk_count=len(found.chunks),
        message_count=found.extent.total,
        message_end_time=found.extent.end_ns,
        message_start_time=found.extent.start_ns,
        metadata_count=len(found.metadata),
        schema_count=len(found.schemas),
    )


def rewrite(path: str, damaged: str) -> Extent:
    """Write the messages of the chunks that are whole into a new file in place of `path`.

    The old one is kept as `damaged`. OSError, BagError.
    """
    target = f"{path}.tmp"
    with open(path, "rb") as stream:
        found = scan(stream)
        if not found.channels:
            raise BagError(f"nothing in {path} can be read")
        try:
            with removed_after_error(target):
                _copy(stream, found, target)
        except OSError as error:
            raise OSError(error.errno, error.strerror, path) from None
    os.replace(path, damaged)
    os.replace(target, path)
    return found.extent


class _ChecksummedFile:
    """Writes a file, with the checksum of what was written."""

    def __init__(self, stream: IO[bytes], crc: int = 0) -> None:
        self._stream = stream
        self.crc = crc

    @property
    def offset(self) -> int:
        return self._stream.tell()

    def write(self, data: bytes) -> None:
        self._stream.write(data)
        self.crc = zlib.crc32(data, self.crc)

    def write_record(self, record: Any) -> None:
        builder = RecordBuilder()
        record.write(builder)
        self.write(builder.end())


def _copy(stream: IO[bytes], found: McapScan, target: str) -> None:
    """Copy the chunks, with heads and indexes that fit, behind the header and all channels."""
    new = McapScan(schemas=found.schemas, channels=found.channels, counts=found.counts)
    new.extent = found.extent
    with open(target, "xb") as file:
        sink = _ChecksummedFile(file)
        sink.write(MAGIC)
        header = found.header or Header(PROFILE, LIBRARY)
        for record in (header, *found.schemas.values(), *found.channels.values()):
            sink.write_record(record)
        for index in found.chunks:
            new.chunks.append(_copy_chunk(stream, index, sink))
        for _, _, place in found.loose:
            stream.seek(place.offset)
            sink.write(stream.read(HEAD.size + place.length))
        for attachment in found.attachments:
            new.attachments.append(dataclasses.replace(attachment, offset=sink.offset))
            stream.seek(attachment.offset)
            for piece in pieces(stream, attachment.length):
                sink.write(piece)
        new.end, new.crc = sink.offset, sink.crc
        file.write(summary_of(new))
        file.flush()
        os.fsync(file.fileno())


def _copy_chunk(stream: IO[bytes], index: ChunkIndex, sink: _ChecksummedFile) -> ChunkIndex:
    """Copy a chunk whose contents are whole; its new index."""
    chunk = _chunk_at(stream, index)
    chunk.message_start_time = index.message_start_time
    chunk.message_end_time = index.message_end_time
    start = sink.offset
    sink.write_record(chunk)
    new = dataclasses.replace(index, chunk_start_offset=start, chunk_length=sink.offset - start)
    return _write_indexes(chunk, new, sink)


def _chunk_at(stream: IO[bytes], index: ChunkIndex) -> Chunk:
    stream.seek(index.chunk_start_offset + HEAD.size)
    chunk: Chunk = parse(Chunk, stream.read(index.chunk_length - HEAD.size))
    return chunk


def _write_indexes(chunk: Chunk, index: ChunkIndex, sink: _ChecksummedFile) -> ChunkIndex:
    """Write the message indexes behind a chunk; its index with them."""
    offsets, start = {}, sink.offset
    for channel_id, entries in message_indexes(records_in(chunk_contents(chunk))).items():
        offsets[channel_id] = sink.offset
        sink.write_record(MessageIndex(channel_id, entries))
    length = sink.offset - start
    return dataclasses.replace(index, message_index_offsets=offsets, message_index_length=length)


def _complete_indexes(stream: IO[bytes], found: McapScan) -> None:
    """Write those behind the last chunk again, where the recorder has written only some."""
    if found.chunk is None or found.chunk.message_index_offsets.keys() == found.indexes.keys():
        return
    last = found.chunks.pop()
    end = last.chunk_start_offset + last.chunk_length
    if end + last.message_index_length != found.end:
        found.chunks.append(last)
        return
    chunk = _chunk_at(stream, last)
    sink = _ChecksummedFile(stream, checksum(stream, 0, end))
    stream.truncate(end)
    stream.seek(end)
    found.chunks.append(_write_indexes(chunk, last, sink))
    found.end, found.crc = sink.offset, sink.crc
