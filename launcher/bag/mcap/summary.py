"""The summary at the end of an MCAP file."""

from __future__ import annotations

import os
from typing import IO, Any

from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    ChunkIndex,
    Footer,
    MetadataIndex,
    Schema,
    Statistics,
)
from mcap.summary import Summary

from launcher.bag.mcap.records import HEAD, MAGIC, Damage, RecordSource, checksum, parse

_FOOTER_BYTES = 20
_CRC_BYTES = 4
_KINDS: dict[int, Any] = {
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.STATISTICS: Statistics,
    Opcode.CHUNK_INDEX: ChunkIndex,
    Opcode.ATTACHMENT_INDEX: AttachmentIndex,
    Opcode.METADATA_INDEX: MetadataIndex,
}


def is_ended(stream: IO[bytes]) -> bool:
    """Whether the file has the bytes with which a finished one ends."""
    size = stream.seek(0, os.SEEK_END)
    stream.seek(max(size - len(MAGIC), 0))
    return size >= 2 * len(MAGIC) and stream.read(len(MAGIC)) == MAGIC


def read_summary(stream: IO[bytes]) -> Summary | None:
    """The summary; None if a finished file has none. Damage if it cannot be used."""
    if not is_ended(stream):
        raise Damage("it ends without a summary: its recorder did not finish it")
    end = footer_offset(stream)
    footer = footer_at(stream, end)
    if not footer.summary_start:
        return None
    check_footer(stream, end, footer)
    found = Summary()
    source = RecordSource(stream, footer.summary_start)
    while source.offset < end:
        place = source.head()
        if place.end > end:
            raise Damage("its summary is damaged")
        if (kind := _KINDS.get(place.opcode)) is None:
            source.skip(place)
        else:
            _add(found, parse(kind, source.contents(place)))
    _check_channels(found)
    return found


def footer_offset(stream: IO[bytes]) -> int:
    """Where the footer of a finished file is."""
    return stream.seek(0, os.SEEK_END) - len(MAGIC) - _FOOTER_BYTES - HEAD.size


def footer_at(stream: IO[bytes], offset: int) -> Footer:
    """Damage if there is none."""
    if offset < len(MAGIC):
        raise Damage("its footer is damaged")
    stream.seek(offset)
    head = stream.read(HEAD.size)
    if HEAD.unpack(head) != (Opcode.FOOTER, _FOOTER_BYTES):
        raise Damage("its footer is damaged")
    footer: Footer = parse(Footer, stream.read(_FOOTER_BYTES))
    return footer


def check_footer(stream: IO[bytes], offset: int, footer: Footer) -> None:
    """Damage if the footer at this offset leads to no summary, or its checksum is wrong."""
    if not len(MAGIC) <= footer.summary_start <= offset:
        raise Damage("its footer is damaged: it says that the summary is elsewhere")
    offsets = footer.summary_offset_start
    if offsets and not footer.summary_start <= offsets <= offset:
        raise Damage("its footer is damaged: it says that the offsets are elsewhere")
    end = offset + HEAD.size + _FOOTER_BYTES - _CRC_BYTES
    if footer.summary_crc not in (0, checksum(stream, footer.summary_start, end)):
        raise Damage("its summary is damaged")


def _add(found: Summary, record: object) -> None:
    match record:
        case Schema():
            found.schemas[record.id] = record
        case Channel():
            found.channels[record.id] = record
        case Statistics():
            found.statistics = record
        case ChunkIndex():
            found.chunk_indexes.append(record)
        case AttachmentIndex():
            found.attachment_indexes.append(record)
        case MetadataIndex():
            found.metadata_indexes.append(record)


def _check_channels(found: Summary) -> None:
    """Damage if the summary is of channels that it does not have."""
    used = set(found.statistics.channel_message_counts) if found.statistics is not None else set()
    for index in found.chunk_indexes:
        used.update(index.message_index_offsets)
    if not used <= found.channels.keys():
        raise Damage("its summary lacks channels")
