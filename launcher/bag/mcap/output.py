"""Writes an MCAP file: messages in chunks, their indexes, and at the end the summary.

The records are those of the library's writer. That one copies each message four times into growing
buffers; the pages of these are new to the process each time, and for messages of megabytes to
touch them takes longer than writing. Here a message is copied once, into its chunk.
"""

from __future__ import annotations

import contextlib
import io
import os
import struct
import sys
import zlib
from array import array
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Channel, ChunkIndex, Header, Metadata, MetadataIndex, Schema

from launcher.bag.bag_model import Extent
from launcher.bag.mcap.records import HEAD, MAGIC, joined_checksum
from launcher.bag.mcap.repair import LIBRARY, PROFILE, summary_of
from launcher.bag.mcap.scan import McapScan
from launcher.posix.write_behind import WriteBehind

_MESSAGE = struct.Struct("<BQHIQQ")  # head; channel, sequence, log time, publish time
_MESSAGE_BYTES = _MESSAGE.size - HEAD.size
_CHUNK = struct.Struct("<QQQI")  # first time, last time, size, checksum
_INDEX = struct.Struct("<HI")  # channel, size
_SIZE = struct.Struct("<Q")
_MOST_PIECES = 64  # of a chunk that is written as it is; more are joined first
_LEAST_JOINED_BYTES = 1 << 18  # of a chunk whose checksum takes longer than to join it
_LEAST_RATIO = 1.02  # of compression, as MIN_COMPRESSION_RATIO in MCAP's library for C++
_SAMPLES, _SAMPLE_BYTES = 16, 4096  # of a chunk; more if it has more messages
_MOST_VAIN = 32  # chunks that samples decide, until one is compressed in any case

# Compressions of chunks: their name in the file, and the level. Of point clouds and images level 1
# leaves 1 to 5 % more bytes than level 3, which takes up to 7 times as long.
_LEVELS = {
    "zstd": ("zstd", 1),
    "zstd_small": ("zstd", 3),
    "lz4": ("lz4", 0),
    "none": ("", 0),
}


class _Encoded(bytes):
    """A record of the summary; the index of a chunk takes a seventh of the memory of an object."""

    __slots__ = ()

    def write(self, builder: RecordBuilder) -> None:
        builder.write(self)


class McapStream:
    """One file. OSError if writing fails; struct.error for a time before 1970.

    A chunk ends after `chunk_bytes`; `compression` is a key of `_LEVELS`. With `is_read_next` the
    file stays in memory for whoever reads it.
    """

    def __init__(
        self, path: str, chunk_bytes: int, compression: str, *, is_read_next: bool = False
    ) -> None:
        self._file = io.FileIO(path, "wb")
        self._behind = None if is_read_next else WriteBehind(self._file.fileno())
        self._chunk_bytes = chunk_bytes
        self._name, level = _LEVELS[compression]
        self._compress = _compressor(self._name, level)
        self._found = McapScan(header=Header(PROFILE, LIBRARY))
        self._parts: list[bytes] = []  # of the chunk
        self._size = 0
        self._vain = 0  # chunks since the last that was compressed without gain, and with it
        self._indexes: dict[int, array[int]] = {}  # channel -> time and offset of each message
        self._write((MAGIC, _bytes_of(self._found.header)))

    @property
    def closed(self) -> bool:
        return self._file.closed

    @property
    def size_bytes(self) -> int:
        """Of what is in the file."""
        return self._found.end

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Its number in the file."""
        number = len(self._found.schemas) + 1
        schema = Schema(id=number, name=name, encoding=encoding, data=data)
        self._found.schemas[number] = schema
        self._add(_bytes_of(schema))
        return number

    def add_channel(
        self, topic: str, encoding: str, schema: int, metadata: Mapping[str, str]
    ) -> int:
        """Its number in the file."""
        number = len(self._found.channels) + 1
        channel = Channel(
            id=number,
            topic=topic,
            message_encoding=encoding,
            metadata=dict(metadata),
            schema_id=schema,
        )
        self._found.channels[number] = channel
        self._add(_bytes_of(channel))
        return number

    def add_message(
        self, channel: int, log_ns: int, publish_ns: int, sequence: int, data: bytes
    ) -> None:
        length = len(data)
        head = _MESSAGE.pack(
            Opcode.MESSAGE, _MESSAGE_BYTES + length, channel, sequence, log_ns, publish_ns
        )
        index = self._indexes.get(channel)
        if index is None:
            index = self._indexes[channel] = array("Q")
        index.append(log_ns)
        index.append(self._size)
        self._parts += (head, data)
        self._size += _MESSAGE.size + length
        if self._size > self._chunk_bytes:
            self.flush()

    def _add(self, record: bytes) -> None:
        self._parts.append(record)
        self._size += len(record)

    def flush(self) -> None:
        """Write the chunk, if it has messages."""
        if not self._indexes:
            return
        parts = self._parts
        if len(parts) > _MOST_PIECES:
            parts = [b"".join(parts)]
        crc = _checksum(parts)
        compressed = self._compressed(parts)
        if compressed is None:
            self._write_chunk(parts, "", crc)
        else:
            self._write_chunk([compressed], self._name, crc)
        self._parts, self._size, self._indexes = [], 0, {}

    def _compressed(self, parts: Sequence[bytes]) -> bytes | None:
        """The contents of the chunk; None if they are written as they are.

        That is if they do not get "materially smaller", as in MCAP's library for C++ without
        `forceCompression`, which is the one of rosbag2. Images and point clouds are often
        compressed already: after a chunk of such, samples of the next one say whether to try.
        """
        if self._compress is None:
            return None
        sample = _sample(parts, self._size) if 0 < self._vain < _MOST_VAIN else b""
        if sample and not _is_smaller(self._compress(sample), sample):
            self._vain += 1
            return None
        data = parts[0] if len(parts) == 1 else b"".join(parts)
        compressed = self._compress(data)
        self._vain = int(not _is_smaller(compressed, data))
        return None if self._vain else compressed

    def _write_chunk(self, parts: Sequence[bytes], compression: str, crc: int) -> None:
        found, size, compressed = self._found, self._size, sum(map(len, parts))
        times = [time for index in self._indexes.values() for time in _ends(index)]
        name = compression.encode()
        fields = _CHUNK.pack(min(times), max(times), size, crc)
        head = fields + len(name).to_bytes(4, "little") + name + _SIZE.pack(compressed)
        length = len(head) + compressed
        chunk = ChunkIndex(
            chunk_length=HEAD.size + length,
            chunk_start_offset=found.end,
            compression=compression,
            compressed_size=compressed,
            message_end_time=max(times),
            message_index_length=0,
            message_index_offsets={},
            message_start_time=min(times),
            uncompressed_size=size,
        )
        indexes = self._index_records(chunk)
        start = HEAD.pack(Opcode.CHUNK, length) + head
        file_crc = zlib.crc32(start, found.crc)
        if compression or size < _LEAST_JOINED_BYTES:
            file_crc = _checksum(parts, file_crc)
        else:
            file_crc = joined_checksum(file_crc, crc, compressed)
        self._write((start, *parts, indexes), zlib.crc32(indexes, file_crc))
        found.chunks.append(_Encoded(_bytes_of(chunk)))
        for channel, index in self._indexes.items():
            number = len(index) // 2
            found.counts[channel] = found.counts.get(channel, 0) + number
            found.extent.merge(Extent({str(channel): number}, *_ends(index)))

    def _index_records(self, chunk: ChunkIndex) -> bytes:
        """Those behind a chunk, which gets their offsets."""
        found = []
        start = chunk.chunk_start_offset + chunk.chunk_length
        for channel, index in self._indexes.items():
            if sys.byteorder == "big":
                index = array("Q", index)
                index.byteswap()
            pairs = index.tobytes()
            chunk.message_index_offsets[channel] = start + chunk.message_index_length
            head = HEAD.pack(Opcode.MESSAGE_INDEX, _INDEX.size + len(pairs))
            found += [head, _INDEX.pack(channel, len(pairs)), pairs]
            chunk.message_index_length += HEAD.size + _INDEX.size + len(pairs)
        return b"".join(found)

    def add_metadata(self, name: str, entries: Mapping[str, str]) -> None:
        """Behind the messages so far."""
        self.flush()
        record = _bytes_of(Metadata(name=name, metadata=dict(entries)))
        index = MetadataIndex(offset=self._found.end, length=len(record), name=name)
        self._write((record,))
        self._found.metadata.append(index)

    def finish(self) -> None:
        """Write the summary, and close the file when it is on the disk."""
        self.flush()
        # topics without messages: what is in the summary has to be in the data, too
        self._write((b"".join(self._parts),))
        _write_all(self._file.fileno(), (summary_of(self._found),))
        if self._behind is not None:
            self._behind.join()
        os.fsync(self._file.fileno())
        self._file.close()

    def abandon(self) -> None:
        """Close the file with whatever has reached it."""
        if self._behind is not None:
            self._behind.close()
        with contextlib.suppress(OSError):  # of a network file system that is full
            self._file.close()

    def _write(self, pieces: Sequence[bytes], crc: int | None = None) -> None:
        """`crc` is that of the file with these, if it is known."""
        found = self._found
        found.crc = _checksum(pieces, found.crc) if crc is None else crc
        _write_all(self._file.fileno(), pieces)
        found.end += sum(map(len, pieces))
        if self._behind is not None:
            self._behind.grown_to(found.end)


def _compressor(name: str, level: int) -> Callable[[bytes], bytes] | None:
    """None for no compression."""
    if name == "zstd":
        import zstandard

        return zstandard.ZstdCompressor(level=level).compress
    if name == "lz4":
        import lz4.frame

        compress: Callable[[bytes], bytes] = lz4.frame.compress
        return compress
    return None


def _sample(parts: Sequence[bytes], size: int) -> bytes:
    """Bytes from all over a chunk, with the begin of each of its parts."""
    step = max(size // _SAMPLES, _SAMPLE_BYTES)
    starts = ((part, at) for part in parts for at in range(0, len(part), step))
    return b"".join(part[at : at + _SAMPLE_BYTES] for part, at in starts)


def _is_smaller(compressed: bytes, data: bytes) -> bool:
    return len(compressed) * _LEAST_RATIO <= len(data)


def _bytes_of(record: Any) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    found: bytes = builder.end()
    return found


def _ends(index: array[int]) -> tuple[int, int]:
    """The first and the last time of a message index."""
    times = index[::2]
    return min(times), max(times)


def _checksum(pieces: Sequence[bytes], crc: int = 0) -> int:
    for piece in pieces:
        crc = zlib.crc32(piece, crc)
    return crc


def _write_all(descriptor: int, pieces: Sequence[bytes]) -> None:
    """In one call, or more where the system takes less. OSError."""
    left: list[bytes | memoryview] = [piece for piece in pieces if piece]
    while left:
        written = os.writev(descriptor, left)
        while left and written >= len(left[0]):
            written -= len(left[0])
            del left[0]
        if written:
            left[0] = memoryview(left[0])[written:]
