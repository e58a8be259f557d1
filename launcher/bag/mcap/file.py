"""An MCAP file of a bag, for reading."""

from __future__ import annotations

import contextlib
import heapq
import itertools
from array import array
from collections.abc import Callable, Iterator, Mapping
from typing import IO, Any

from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, ChunkIndex, Schema
from mcap.records import Message as Record

from launcher.bag import metadata
from launcher.bag.bag_model import (
    LAST_NS,
    BagError,
    ChannelTopic,
    Definition,
    Extent,
    Message,
    Span,
    TimesBlock,
    Topic,
    merged,
    never,
    time_blocks,
)
from launcher.bag.mcap.records import (
    HEAD,
    MAGIC,
    Damage,
    RecordSource,
    chunk_contents,
    index_times,
    message_of,
    parse,
    records_in,
)
from launcher.bag.mcap.scan import McapScan, scan
from launcher.bag.mcap.summary import is_ended, read_summary


class McapFile:
    """Messages of a file with a summary, or, without one, of the chunks that are whole.

    `unfinished` says why there is no summary; None for a whole file. `notes` are about topics.
    BagError if it is no MCAP file; OSError.
    """

    def __init__(self, stream: IO[bytes], path: str) -> None:
        self._stream = stream
        self._path = path
        self.unfinished: str | None = None
        self.notes: list[str] = []
        start = stream.read(len(MAGIC))
        is_cut = len(start) < len(MAGIC) and MAGIC.startswith(start)
        if start != MAGIC and not is_cut and not is_ended(stream):
            raise BagError(f"{path} is not an MCAP file")
        self._scan: McapScan | None = None
        self._chunks: list[ChunkIndex] = []
        self.extent = Extent()
        self._channels: Mapping[int, Channel] = {}
        self._schemas: Mapping[int, Schema] = {}
        self._counts: Mapping[int, int] = {}
        self._left_out: frozenset[int] = frozenset()  # channels
        if not self._take_summary():
            self._take_scan()
        self.parts = parts_of(self._channels, self._schemas, self._counts, self.notes)
        self.topics = merged(part.topic for part in self.parts)

    def _take_summary(self) -> bool:
        """Whether the file has one that says where the messages are."""
        try:
            summary = read_summary(self._stream)
        except Damage:
            return False
        if summary is None or summary.statistics is None:
            return False
        statistics = summary.statistics
        if statistics.message_count and not summary.chunk_indexes:
            return False
        self._channels, self._schemas = summary.channels, summary.schemas
        self._chunks, self._counts = summary.chunk_indexes, statistics.channel_message_counts
        self.extent = Extent(
            _by_topic(statistics.channel_message_counts, self._channels),
            statistics.message_start_time,
            statistics.message_end_time,
        )
        return True

    def _take_scan(self) -> None:
        found = self._scan = scan(self._stream)
        self._chunks, self.extent = found.chunks, found.extent
        self._channels, self._schemas = found.channels, found.schemas
        self._counts = found.counts
        if not found.finished or found.faults:
            self.unfinished = found.faults[-1].text if found.faults else "it has no summary"

    def leave_out(self, keys: frozenset[int]) -> None:
        """Without these channels from now on; the times of a damaged file stay those of all."""
        if not keys:
            return
        self._left_out = keys
        self.topics = merged(part.topic for part in self.parts if part.key not in keys)
        counts = {one: n for one, n in self._counts.items() if one not in keys}
        start_ns, end_ns = self.extent.start_ns, self.extent.end_ns
        self.extent = Extent(_by_topic(counts, self._channels), start_ns, end_ns)
        with contextlib.suppress(BagError):
            times = Extent()
            for _, found in self.times():
                for topic, one in found.items():
                    if one:
                        times.merge(Extent({topic: len(one)}, min(one), max(one)))
            if times.counts:
                self.extent.start_ns, self.extent.end_ns = times.start_ns, times.end_ns

    def messages(
        self, topics: frozenset[str] | None, span: Span, stopped: Callable[[], bool] = never
    ) -> Iterator[Message]:
        """In the order of their times; BagError at a damaged record."""
        number = 0
        try:
            records = self._chunked(topics, span, stopped)
            if self._scan is not None and self._scan.loose:
                loose = self._loose(self._scan, topics, span)
                records = heapq.merge(records, loose, key=lambda one: one[1].log_time)
            for channel, record in records:
                number += 1
                yield Message(
                    channel.topic,
                    record.log_time,
                    record.publish_time,
                    record.sequence,
                    record.data,
                )
        except (Damage, MemoryError, OverflowError) as error:
            raise self._damaged(str(error) or type(error).__name__) from None
        counts = self.extent.counts
        total = sum(count for topic, count in counts.items() if topics is None or topic in topics)
        if span == Span() and number < total and not stopped():
            raise self._damaged(f"its summary counts {total} messages, {number} could be read")

    def _damaged(self, reason: str) -> BagError:
        return BagError(
            f"{self._path} is damaged: {reason}", hint=f"bag check {self._path} says where"
        )

    def times(self) -> Iterator[TimesBlock]:
        """From the indexes behind the chunks, without decompressing these. BagError."""
        try:
            indexed = sum(len(one) for _, found in self._indexed() for one in found.values())
        except Damage:
            indexed = -1
        if indexed == self.extent.total:
            try:
                yield from self._indexed()
            except Damage as damage:
                raise self._damaged(str(damage)) from None
        else:  # the file has no such indexes, or some are missing
            yield from time_blocks((one.topic, one.log_ns) for one in self.messages(None, Span()))

    def _indexed(self) -> Iterator[TimesBlock]:
        """A block for each chunk. Damage."""
        size = RecordSource(self._stream).size
        chunks = sorted(self._chunks, key=lambda one: one.message_start_time)
        for chunk, following in itertools.zip_longest(chunks, chunks[1:]):
            start = chunk.chunk_start_offset + chunk.chunk_length
            if start + chunk.message_index_length > size:
                raise Damage("the index of a chunk is elsewhere")
            self._stream.seek(start)
            found: dict[str, array[int]] = {}
            for channel_id, times in index_times(self._stream.read(chunk.message_index_length)):
                if channel_id not in self._channels:
                    raise Damage("an index is of an unknown channel")
                if channel_id not in self._left_out:
                    found.setdefault(self._channels[channel_id].topic, array("q")).extend(times)
            yield (following or chunk).message_start_time, found

    def _chunked(
        self, topics: frozenset[str] | None, span: Span, stopped: Callable[[], bool]
    ) -> Iterator[tuple[Channel, Record]]:
        """Sorted by time: a chunk is read when the messages before its first one are over."""
        chunks = [one for one in self._chunks if self._may_have(one, topics, span)]
        chunks.sort(key=lambda one: (one.message_start_time, one.chunk_start_offset))
        waiting: list[tuple[int, int, Channel, Record]] = []
        for number, chunk in enumerate(chunks):
            if stopped():
                return
            found = sorted(
                (record.log_time, number << 64 | offset, channel, record)
                for offset, channel, record in self._of_chunk(chunk, topics, span)
            )
            following = chunks[number + 1 : number + 2]
            before_ns = following[0].message_start_time if following else LAST_NS
            for one in found:
                if waiting or one[0] >= before_ns:
                    heapq.heappush(waiting, one)
                else:
                    yield one[2:]
            while waiting and waiting[0][0] < before_ns:
                yield heapq.heappop(waiting)[2:]
        while waiting:
            yield heapq.heappop(waiting)[2:]

    def _may_have(self, chunk: ChunkIndex, topics: frozenset[str] | None, span: Span) -> bool:
        if span.start_ns is not None and chunk.message_end_time < span.start_ns:
            return False
        if span.end_ns is not None and chunk.message_start_time >= span.end_ns:
            return False
        channels = chunk.message_index_offsets
        if topics is None or not channels:  # without indexes, it may have any
            return True
        known = (self._channels.get(one) for one in channels)
        return any(one is None or one.topic in topics for one in known)

    def _of_chunk(
        self, chunk: ChunkIndex, topics: frozenset[str] | None, span: Span
    ) -> Iterator[tuple[int, Channel, Record]]:
        source = RecordSource(self._stream, chunk.chunk_start_offset, has_crc=False)
        place = source.head()
        if place.opcode != Opcode.CHUNK:
            raise Damage("its summary says that a chunk is where none is")
        try:
            data = chunk_contents(parse(Chunk, source.contents(place)))
        except Damage as damage:
            raise Damage(f"a chunk is damaged ({damage})") from None
        for offset, record in records_in(data):
            if isinstance(record, Record):
                channel = self._channels.get(record.channel_id)
                if channel is None:
                    raise Damage(f"a message belongs to the unknown channel {record.channel_id}")
                if self._is_chosen(channel, record.log_time, topics, span):
                    yield offset, channel, record

    def _loose(
        self, found: McapScan, topics: frozenset[str] | None, span: Span
    ) -> Iterator[tuple[Channel, Record]]:
        """Messages that are in no chunk."""
        for log_ns, channel_id, place in sorted(found.loose):
            channel = self._channels[channel_id]
            if self._is_chosen(channel, log_ns, topics, span):
                self._stream.seek(place.offset + HEAD.size)
                yield channel, message_of(self._stream.read(place.length))

    def _is_chosen(
        self, channel: Channel, log_ns: int, topics: frozenset[str] | None, span: Span
    ) -> bool:
        if channel.id in self._left_out or (topics is not None and channel.topic not in topics):
            return False
        if span.start_ns is not None and log_ns < span.start_ns:
            return False
        return span.end_ns is None or log_ns < span.end_ns

    def close(self) -> None:
        self._stream.close()


def _by_topic(counts: Mapping[int, int], channels: Mapping[int, Channel]) -> dict[str, int]:
    found: dict[str, int] = {}
    for channel_id, count in counts.items():
        topic = channels[channel_id].topic
        found[topic] = found.get(topic, 0) + count
    return found


def parts_of(
    channels: Mapping[int, Channel],
    schemas: Mapping[int, Schema],
    counts: Mapping[int, int],
    notes: list[str],
) -> list[ChannelTopic]:
    """A topic for each channel; `notes` gets what is wrong with them."""
    return [
        ChannelTopic(number, _topic(one, schemas.get(one.schema_id), notes), counts.get(number, 0))
        for number, one in channels.items()
    ]


def _topic(channel: Channel, schema: Any, notes: list[str]) -> Topic:
    definition = None
    if schema is not None and schema.data:
        text = schema.data.decode("utf-8", "surrogateescape")  # that of protobuf is no text
        definition = Definition(text=text, encoding=schema.encoding)
    return Topic(
        name=channel.topic,
        type=schema.name if schema is not None else "",
        serialization=channel.message_encoding,
        qos=metadata.known_qos(channel.topic, channel.metadata.get("offered_qos_profiles"), notes),
        type_hash=channel.metadata.get("topic_type_hash", ""),
        definition=definition,
    )
