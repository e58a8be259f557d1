"""An MCAP file of a bag, for reading."""

from __future__ import annotations

import struct
from array import array
from collections.abc import Iterator, Mapping
from typing import IO, Any

from mcap.reader import SeekingReader
from mcap.records import Channel, Schema
from mcap.records import Message as Record

from launcher.bag import metadata
from launcher.bag.errors import BagError
from launcher.bag.mcap_scan import MAGIC, Scan, chunk_of, index_times, records_of, scan
from launcher.bag.model import Definition, Extent, Message, Span, Times, Topic, merged


class McapFile:
    """Messages of a file with a summary, or, without one, of the chunks that are whole.

    `unfinished` says why there is no summary; None for a whole file. BagError if it is no MCAP
    file; OSError.
    """

    def __init__(self, stream: IO[bytes], path: str) -> None:
        self._stream = stream
        self._path = path
        self.unfinished: str | None = None
        self._scan: Scan | None = None
        start = stream.read(len(MAGIC))
        if start != MAGIC and not (len(start) < len(MAGIC) and MAGIC.startswith(start)):
            raise BagError(f"{path} is not an MCAP file")
        stream.seek(0)
        try:
            self._reader = SeekingReader(stream, validate_crcs=True)
            summary = self._reader.get_summary()
        except Exception:  # the library reads a footer wherever it would be
            summary = None
        if summary is None or summary.statistics is None:
            found = self._scan = scan(stream)
            self._chunks = found.chunks
            self._channels, self._schemas = found.channels, found.schemas
            self.extent = found.extent
            if not found.finished:
                self.unfinished = found.faults[-1].text if found.faults else "it has no summary"
        else:
            self._channels, self._schemas = summary.channels, summary.schemas
            self._chunks = summary.chunk_indexes
            told = summary.statistics
            self.extent = Extent(
                _by_topic(told.channel_message_counts, self._channels),
                told.message_start_time,
                told.message_end_time,
            )
        self.topics = merged(topics_of(self._channels, self._schemas))

    def messages(self, topics: frozenset[str] | None, span: Span) -> Iterator[Message]:
        """In the order of their times; BagError at a damaged record."""
        number = 0
        try:
            records = self._indexed(topics, span) if self._scan is None else self._scanned(span)
            for channel, record in records:
                if topics is None or channel.topic in topics:
                    number += 1
                    yield Message(
                        channel.topic,
                        record.log_time,
                        record.publish_time,
                        record.sequence,
                        record.data,
                    )
        except (BagError, OSError):
            raise
        except Exception as error:  # of the library, or of what decompresses
            raise self._damaged(" ".join(str(error).split()) or type(error).__name__) from None
        counts = self.extent.counts
        told = sum(count for topic, count in counts.items() if topics is None or topic in topics)
        if span == Span() and number < told:
            raise self._damaged(f"its summary counts {told} messages, {number} could be read")

    def _damaged(self, reason: str) -> BagError:
        return BagError(
            f"{self._path} is damaged: {reason}", hint=f"bag check {self._path} says where"
        )

    def times(self) -> Times:
        """From the indexes behind the chunks, without decompressing these."""
        try:
            found = self._index_times()
        except (OSError, ValueError, LookupError, struct.error):
            found = {}
        if sum(map(len, found.values())) == self.extent.total:
            return found
        found = {}  # the file has no such indexes, or some are missing
        for message in self.messages(None, Span()):
            found.setdefault(message.topic, array("q")).append(message.log_ns)
        return found

    def _index_times(self) -> Times:
        found: Times = {}
        for chunk in self._chunks:
            self._stream.seek(chunk.chunk_start_offset + chunk.chunk_length)
            for channel_id, times in index_times(self._stream.read(chunk.message_index_length)):
                topic = self._channels[channel_id].topic
                found.setdefault(topic, array("q")).extend(times)
        return found

    def _indexed(
        self, topics: frozenset[str] | None, span: Span
    ) -> Iterator[tuple[Channel, Record]]:
        found = self._reader.iter_messages(
            topics, starting_at=span.start_ns, ending_before=span.end_ns
        )
        for _, channel, record in found:
            yield channel, record

    def _scanned(self, span: Span) -> Iterator[tuple[Channel, Record]]:
        """From the whole chunks of a file without a summary, each sorted by time."""
        assert self._scan is not None
        chunks = sorted(self._scan.chunks, key=lambda one: one.message_start_time)
        if not chunks and self._scan.loose:
            raise ValueError("its messages are not in chunks")
        for index in chunks:
            self._stream.seek(index.chunk_start_offset)
            contents = self._stream.read(index.chunk_length)
            records = [one for one in records_of(chunk_of(contents)) if isinstance(one, Record)]
            records.sort(key=lambda one: one.log_time)
            for one in records:
                after = span.start_ns is None or one.log_time >= span.start_ns
                if after and (span.end_ns is None or one.log_time < span.end_ns):
                    yield self._channels[one.channel_id], one

    def close(self) -> None:
        self._stream.close()


def _by_topic(counts: Mapping[int, int], channels: Mapping[int, Channel]) -> dict[str, int]:
    found: dict[str, int] = {}
    for channel_id, count in counts.items():
        topic = channels[channel_id].topic
        found[topic] = found.get(topic, 0) + count
    return found


def topics_of(channels: Mapping[int, Channel], schemas: Mapping[int, Schema]) -> list[Topic]:
    """A topic for each channel."""
    return [_topic(one, schemas.get(one.schema_id)) for one in channels.values()]


def _topic(channel: Channel, schema: Any) -> Topic:
    definition = None
    if schema is not None and schema.data:
        text = schema.data.decode("utf-8", "surrogateescape")  # that of protobuf is no text
        definition = Definition(text=text, encoding=schema.encoding)
    return Topic(
        name=channel.topic,
        type=schema.name if schema is not None else "",
        serialization=channel.message_encoding,
        qos=metadata.qos_from(channel.metadata.get("offered_qos_profiles")),
        type_hash=channel.metadata.get("topic_type_hash", ""),
        definition=definition,
    )
