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
from mcap.records import DataEnd, Footer, Header, Statistics, SummaryOffset

from launcher.bag.errors import BagError
from launcher.bag.mcap_scan import MAGIC, Scan, scan
from launcher.bag.model import Extent

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
        stream.write(summary_of(found))
        stream.flush()
        os.fsync(stream.fileno())
    return found.extent


def _write_empty(stream: IO[bytes]) -> None:
    stream.truncate(0)
    stream.seek(0)
    head = RecordBuilder()
    Header(PROFILE, LIBRARY).write(head)
    stream.write(MAGIC + head.end())
    stream.flush()


def summary_of(found: Scan) -> bytes:
    """The end of a file whose data end at `found.end`."""
    ending = RecordBuilder()
    DataEnd(0).write(ending)
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


def _statistics(found: Scan) -> Statistics:
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
        if found.header is None or not found.channels:
            raise BagError(f"nothing in {path} can be read")
        try:
            _copy(stream, found, target)
        except BaseException:
            os.unlink(target)
            raise
    os.replace(path, damaged)
    os.replace(target, path)
    return found.extent


def _copy(stream: IO[bytes], found: Scan, target: str) -> None:
    """Copy the chunks as they are, with their indexes, behind the header and all channels."""
    new = Scan(schemas=found.schemas, channels=found.channels, counts=found.counts)
    new.extent = found.extent
    with open(target, "xb") as sink:
        head = RecordBuilder()
        for record in (found.header, *found.schemas.values(), *found.channels.values()):
            record.write(head)
        sink.write(MAGIC)
        sink.write(head.end())
        for chunk in found.chunks:
            shift = sink.tell() - chunk.chunk_start_offset
            indexes = {one: at + shift for one, at in chunk.message_index_offsets.items()}
            new.chunks.append(
                dataclasses.replace(
                    chunk, chunk_start_offset=sink.tell(), message_index_offsets=indexes
                )
            )
            stream.seek(chunk.chunk_start_offset)
            sink.write(stream.read(chunk.chunk_length + chunk.message_index_length))
        new.end = sink.tell()
        sink.write(summary_of(new))
        sink.flush()
        os.fsync(sink.fileno())
