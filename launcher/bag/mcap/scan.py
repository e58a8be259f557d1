"""Reads an MCAP file from its beginning, as far as it is whole, and says what is wrong with it.

A recorder that was killed leaves a file without the summary that readers look for at the end, and
perhaps with half a chunk. In a file that was finished, all that cannot be read is damage: the
summary says where the next chunk is.
"""

from __future__ import annotations

import bisect
import contextlib
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import IO, Any

from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    Message,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
)
from mcap.summary import Summary

from launcher.bag.bag_model import Extent
from launcher.bag.mcap.records import (
    HEAD,
    MAGIC,
    Damage,
    RecordPlace,
    RecordSource,
    attachment_index,
    check_chunk_length,
    chunk_contents,
    message_indexes,
    parse,
    records_in,
)
from launcher.bag.mcap.summary import (
    check_footer,
    footer_at,
    footer_offset,
    is_ended,
    read_summary,
)

_DATA_END_BYTES = 4
_OF_SUMMARY = (
    Opcode.DATA_END,
    Opcode.STATISTICS,
    Opcode.CHUNK_INDEX,
    Opcode.ATTACHMENT_INDEX,
    Opcode.METADATA_INDEX,
    Opcode.SUMMARY_OFFSET,
    Opcode.FOOTER,
)


@dataclass(frozen=True, slots=True)
class McapFault:
    """What is wrong, and at which byte of the file. `lost` says whether data may be."""

    offset: int
    text: str
    lost: bool = True


@dataclass(slots=True)
class McapScan:
    """What a file has. `end` is the offset behind the last whole record of its data.

    `crc` is the checksum of all before `end`; `loose` are messages outside of chunks: time,
    channel, place.
    """

    header: Header | None = None
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    chunks: list[ChunkIndex] = field(default_factory=list)
    metadata: list[MetadataIndex] = field(default_factory=list)
    attachments: list[AttachmentIndex] = field(default_factory=list)
    counts: dict[int, int] = field(default_factory=dict)
    extent: Extent = field(default_factory=Extent)
    custom: dict[str, dict[str, str]] = field(default_factory=dict)
    faults: list[McapFault] = field(default_factory=list)
    end: int = 0
    crc: int = 0
    finished: bool = False
    loose: list[tuple[int, int, RecordPlace]] = field(default_factory=list)
    chunk: ChunkIndex | None = None  # the one whose message indexes follow
    indexes: dict[int, list[tuple[int, int]]] = field(default_factory=dict)  # what they should have


def scan(stream: IO[bytes]) -> McapScan:
    """Read all of a file. OSError; faults of the contents are in the result."""
    found = McapScan()
    size = stream.seek(0, os.SEEK_END)
    stream.seek(0)
    start = stream.read(len(MAGIC))
    if size < len(MAGIC) and MAGIC.startswith(start):
        found.faults.append(McapFault(0, "it is empty: its recorder was killed", lost=False))
        return found
    was_finished = is_ended(stream)
    if start != MAGIC:
        text = "its first bytes are damaged" if was_finished else "it is not an MCAP file"
        found.faults.append(McapFault(0, text))
        if not was_finished:
            return found
    summary = None
    with contextlib.suppress(Damage):  # without a summary, or with a damaged one
        summary = read_summary(stream)
    if summary is not None:  # for a chunk whose channels are in a damaged one
        found.schemas.update(summary.schemas)
        found.channels.update(summary.channels)
    _DataReader(stream, found, summary, was_finished).read()
    return found


class _DataReader:
    """Reads the data of a file, and then its end."""

    def __init__(
        self, stream: IO[bytes], found: McapScan, summary: Summary | None, was_finished: bool
    ) -> None:
        self._stream = stream
        self._found = found
        self._was_finished = was_finished
        self._is_gapless = True  # no record was skipped, so that the checksum counts
        chunks = [] if summary is None else summary.chunk_indexes
        self._chunks = frozenset(one.chunk_start_offset for one in chunks)
        starts = sorted(_starts(stream, summary))
        self._source = RecordSource(stream)
        self._starts = [one for one in starts if one < self._source.size]
        self._source.read(len(MAGIC))

    def read(self) -> None:
        found, source = self._found, self._source
        found.end, found.crc = source.offset, source.crc
        while True:
            place, before = None, source.offset
            try:
                place = source.head()
                if self._is_end(place):
                    self._read_end(place)
                    return
                self._check_place(place)
                self._take(place)
            except Damage as damage:
                is_cut = place is None and not self._was_finished
                self._note(McapFault(before, str(damage), lost=not is_cut))
                if is_cut or not self._go_on(before, place):
                    return
            found.end, found.crc = source.offset, source.crc

    def _note(self, fault: McapFault) -> None:
        """Once, where a whole part of the file is not what it should be."""
        if not any(fault.text == one.text for one in self._found.faults[-1:]):
            self._found.faults.append(fault)

    def _next_start(self, offset: int) -> int | None:
        """The first place behind an offset where, as the summary says, a record begins."""
        index = bisect.bisect_right(self._starts, offset)
        return self._starts[index] if index < len(self._starts) else None

    def _is_end(self, place: RecordPlace) -> bool:
        if place.opcode == Opcode.FOOTER:
            return place.end + len(MAGIC) == self._source.size
        return place.opcode == Opcode.DATA_END and place.length == _DATA_END_BYTES

    def _check_place(self, place: RecordPlace) -> None:
        """Damage if a record is not where, or what, it can be."""
        following = self._next_start(place.offset)
        if place.offset in self._chunks and place.opcode != Opcode.CHUNK:
            raise Damage("a chunk is damaged (its head)")
        if following is not None and place.end > following and not self._is_chunk(place):
            raise Damage(f"a {place.name} is damaged (its length)")
        if place.opcode in _OF_SUMMARY:
            raise Damage("the end of its data is damaged")

    def _is_chunk(self, place: RecordPlace) -> bool:
        """Whether a record is a chunk of this length, whatever the summary says of it."""
        if place.opcode != Opcode.CHUNK:
            return False
        try:
            check_chunk_length(self._source.peek(place, 128), place.length)
        except Damage:
            return False
        return True

    def _go_on(self, offset: int, place: RecordPlace | None) -> bool:
        """Behind a damaged record: at its end, or else at the next one; whether there is one."""
        following = self._next_start(offset)
        if place is not None and (following is None or place.end <= following):
            self._source.resume(place)
            return True
        self._is_gapless = False
        self._found.chunk = None
        if following is not None:
            self._source.seek(following)
        return following is not None

    def _take(self, place: RecordPlace) -> None:
        found = self._found
        if not found.header and place.opcode != Opcode.HEADER and place.offset == len(MAGIC):
            found.faults.append(McapFault(place.offset, "its header is damaged"))
        if place.opcode == Opcode.ATTACHMENT:
            found.attachments.append(attachment_index(self._source, place))
            return
        contents = self._source.contents(place)
        match place.opcode:
            case Opcode.HEADER:
                found.header = parse(Header, contents)
            case Opcode.SCHEMA:
                self._count(parse(Schema, contents))
            case Opcode.CHANNEL:
                self._count(parse(Channel, contents))
            case Opcode.MESSAGE:
                message = parse(Message, contents)
                self._count(message)
                found.loose.append((message.log_time, message.channel_id, place))
            case Opcode.CHUNK:
                found.chunk = None
                self._take_chunk(place, parse(Chunk, contents))
            case Opcode.MESSAGE_INDEX:
                self._take_index(place, parse(MessageIndex, contents))
            case Opcode.METADATA:
                one = parse(Metadata, contents)
                length = HEAD.size + place.length
                found.metadata.append(
                    MetadataIndex(offset=place.offset, length=length, name=one.name)
                )
                found.custom[one.name] = one.metadata

    def _take_chunk(self, place: RecordPlace, chunk: Chunk) -> None:
        found = self._found
        try:
            records = list(records_in(chunk_contents(chunk)))
        except Damage as damage:
            raise Damage(f"a chunk is damaged ({damage})") from None
        found.indexes = message_indexes(records)
        own = {one.id for _, one in records if isinstance(one, Channel)}
        if unknown := found.indexes.keys() - found.channels.keys() - own:
            raise Damage(f"a message belongs to the unknown channel {min(unknown)}")
        for _, record in records:
            self._count(record)
        times = [time for index in found.indexes.values() for time, _ in index] or [0]
        found.chunk = ChunkIndex(
            chunk_length=HEAD.size + place.length,
            chunk_start_offset=place.offset,
            compression=chunk.compression,
            compressed_size=len(chunk.data),
            message_end_time=max(times),
            message_index_length=0,
            message_index_offsets={},
            message_start_time=min(times),
            uncompressed_size=chunk.uncompressed_size,
        )
        found.chunks.append(found.chunk)
        if (chunk.message_start_time, chunk.message_end_time) != (min(times), max(times)):
            raise Damage("the head of a chunk does not fit its messages")

    def _take_index(self, place: RecordPlace, index: MessageIndex) -> None:
        chunk = self._found.chunk
        if chunk is None:
            return
        chunk.message_index_offsets[index.channel_id] = place.offset
        chunk.message_index_length += HEAD.size + place.length
        if sorted(index.records) != sorted(self._found.indexes.get(index.channel_id, ())):
            raise Damage("an index does not fit the messages of its chunk")

    def _count(self, record: object) -> None:
        found = self._found
        match record:
            case Schema():
                found.schemas[record.id] = record
            case Channel():
                found.channels[record.id] = record
            case Message():
                channel = found.channels.get(record.channel_id)
                if channel is None:
                    raise Damage(f"a message belongs to the unknown channel {record.channel_id}")
                found.counts[channel.id] = found.counts.get(channel.id, 0) + 1
                found.extent.add(channel.topic, record.log_time)

    def _read_end(self, place: RecordPlace) -> None:
        """What is behind the data; faults there lose none."""
        found = self._found
        try:
            if place.opcode != Opcode.DATA_END:
                self._note(McapFault(place.offset, "the end of its data is damaged"))
                return
            end: DataEnd = parse(DataEnd, self._source.contents(place))
            if end.data_section_crc not in (0, found.crc) and self._is_gapless:
                text = "the checksum of its data is wrong"
                if not any(fault.lost for fault in found.faults):
                    found.faults.append(McapFault(place.offset, text))
            self._check_summary()
        except Damage as damage:
            found.faults.append(McapFault(found.end, str(damage), lost=False))

    def _check_summary(self) -> None:
        footer = self._footer()
        if footer.summary_start == 0:
            self._found.finished = False
            raise Damage("it has no summary")
        summary = read_summary(self._stream)
        if summary is not None and not self._found.faults:
            _compare(self._found, summary)
        self._found.finished = True

    def _footer(self) -> Footer:
        source = self._source
        while True:
            place = source.head()
            if place.opcode == Opcode.FOOTER:
                break
            source.skip(place)
        footer = footer_at(self._stream, place.offset)
        if self._stream.read(len(MAGIC)) != MAGIC:
            raise Damage("its last bytes are missing")
        if place.end + len(MAGIC) != source.size:
            raise Damage("there are bytes behind its end")
        if footer.summary_start:
            check_footer(self._stream, place.offset, footer)
        return footer


def _starts(stream: IO[bytes], summary: Summary | None) -> Iterator[int]:
    """Where records of the data begin, as the summary says."""
    if summary is None:
        return
    yield from (one.chunk_start_offset for one in summary.chunk_indexes)
    yield from (one.offset for one in summary.metadata_indexes)
    yield from (one.offset for one in summary.attachment_indexes)
    footer = footer_at(stream, footer_offset(stream))
    yield footer.summary_start - HEAD.size - _DATA_END_BYTES


def _compare(found: McapScan, summary: Summary) -> None:
    """Damage if a summary says something else than the data."""
    statistics = summary.statistics
    if statistics is not None:
        if statistics.message_count != found.extent.total:
            counted = f"its summary counts {statistics.message_count} messages"
            raise Damage(f"{counted}, it has {found.extent.total}")
        by_channel = statistics.channel_message_counts
        counts = {one: count for one, count in by_channel.items() if count}
        times = (statistics.message_start_time, statistics.message_end_time)
        own_times = (found.extent.start_ns, found.extent.end_ns)
        if counts != found.counts or (found.extent.total and times != own_times):
            raise Damage("its summary does not fit its messages")
    for name, indexes, own in (
        ("a chunk", summary.chunk_indexes, found.chunks),
        ("metadata", summary.metadata_indexes, found.metadata),
        ("an attachment", summary.attachment_indexes, found.attachments),
    ):
        if indexes and _by_offset(indexes) != _by_offset(own):
            raise Damage(f"its summary does not fit {name}")


def _by_offset(records: Iterable[Any]) -> list[Any]:
    return sorted(records, key=lambda one: getattr(one, "chunk_start_offset", None) or one.offset)
