"""Our writer of MCAP files: the records of the library's writer, byte by byte."""

from __future__ import annotations

import os
import threading
import zlib
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from mcap.data_stream import RecordBuilder
from mcap.records import Channel, DataEnd, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

from launcher.bag.compression import PRESETS
from launcher.bag.mcap import output
from launcher.bag.mcap.output import McapStream
from launcher.bag.mcap.records import joined_checksum
from launcher.bag.mcap.scan import scan
from launcher.bag.writer import Storage
from launcher.posix import write_behind
from tests.support.bags import agreed_counts, counting, write_bag

CHUNK_BYTES = 20_000
COMPRESSIONS = {
    "none": CompressionType.NONE,
    "lz4": CompressionType.LZ4,
    "zstd_small": CompressionType.ZSTD,  # of the library's level
}


def contents() -> list[tuple[int, int, int, int, bytes]]:
    """Channel, times, number and data: chunks of many messages, of one, and times out of order."""
    sizes = [10] * 1500 + [30_000, 500, 0, 70_000]
    return [
        (n % 3 % 2 + 1, 10**18 + n * 1000 * (-1) ** n, n, n, os.urandom(size // 2) + bytes(size))
        for n, size in enumerate(sizes)
    ]


def by_library(path: Path, compression: CompressionType, messages: list) -> bytes:
    """The data section of its file; it begins the third channel after some messages."""
    with path.open("wb") as stream:
        options = {"chunk_size": CHUNK_BYTES, "compression": compression}
        writer = Writer(stream, **options, enable_data_crcs=True)
        writer.start(profile="ros2", library="launcher")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
        for name in ("/a", "/b"):
            writer.register_channel(name, "cdr", schema, {"topic_type_hash": "1"})
        for number, (channel, log_ns, publish_ns, sequence, data) in enumerate(messages):
            if number == len(messages) // 2:
                writer.register_channel("/later", "cdr", schema, {})
            writer.add_message(channel, log_ns, data, publish_ns, sequence)
        writer.flush()
        writer.add_metadata("rosbag2", {"x": "y"})
        writer.finish()
    return data_of(path)


def by_us(
    path: Path, compression: str, messages: list, before_end: Callable[[], None] = lambda: None
) -> bytes:
    writer = McapStream(str(path), CHUNK_BYTES, compression)
    schema = writer.add_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
    for name in ("/a", "/b"):
        writer.add_channel(name, "cdr", schema, {"topic_type_hash": "1"})
    for number, message in enumerate(messages):
        if number == len(messages) // 2:
            writer.add_channel("/later", "cdr", schema, {})
        writer.add_message(*message)
    writer.add_metadata("rosbag2", {"x": "y"})
    assert writer.size_bytes == path.stat().st_size
    before_end()
    writer.finish()
    return data_of(path)


def data_of(path: Path) -> bytes:
    """All before the summary; that is whole, too."""
    with path.open("rb") as stream:
        found = scan(stream)
        assert not found.faults
        assert found.finished
    end = RecordBuilder()
    DataEnd(found.crc).write(end)
    record = end.end()
    raw = path.read_bytes()
    assert raw[found.end : found.end + len(record)] == record
    return raw[: found.end]


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_the_data_are_those_of_the_library(tmp_path: Path, compression: str):
    messages = contents()
    expected = by_library(tmp_path / "library.mcap", COMPRESSIONS[compression], messages)

    assert by_us(tmp_path / "ours.mcap", compression, messages) == expected


def test_a_system_that_takes_less_gets_the_rest(tmp_path: Path, monkeypatch):
    messages = contents()
    expected = by_us(tmp_path / "whole.mcap", "none", messages)
    monkeypatch.setattr(os, "writev", lambda file, pieces: os.write(file, pieces[0][:7001]))

    assert by_us(tmp_path / "parts.mcap", "none", messages) == expected


@pytest.mark.parametrize("preset", PRESETS)
def test_each_preset_can_be_read(tmp_path: Path, preset: str):
    messages = counting("/a", 500)
    bag = write_bag(tmp_path / "b", messages, storage=Storage(chunk_compression=PRESETS[preset]))

    assert agreed_counts(bag) == {"/a": 500}


def test_topics_without_messages_are_in_the_data(tmp_path: Path):
    """More than the system takes pieces in one call."""
    path = tmp_path / "x.mcap"
    writer = McapStream(str(path), CHUNK_BYTES, "none")
    schema = writer.add_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
    for number in range(1100):
        writer.add_channel(f"/{number}", "cdr", schema, {})
    writer.finish()

    with path.open("rb") as stream:
        kinds = Counter(type(record) for record in StreamReader(stream).records)
    assert (kinds[Schema], kinds[Channel]) == (2, 2200)  # here and in the summary


@pytest.mark.parametrize(("compression", "name"), [("none", ""), ("lz4", "lz4"), ("zstd", "zstd")])
def test_what_does_not_get_smaller_is_written_as_it_is(tmp_path: Path, compression: str, name: str):
    noise, text = os.urandom(300_000), bytes(300_000)
    kinds = [noise, noise, text, noise, text, text]
    path = tmp_path / "x.mcap"
    by_us(path, compression, [(1, n, n, n, data) for n, data in enumerate(kinds)])

    with path.open("rb") as stream:
        chunks = scan(stream).chunks
    assert [one.compression for one in chunks] == ["" if one is noise else name for one in kinds]


def test_samples_do_not_decide_for_ever(tmp_path: Path, monkeypatch):
    """Of noise that is there twice, no sample gets smaller, but the whole does."""
    monkeypatch.setattr(output, "_MOST_VAIN", 3)
    noise, other, path = os.urandom(150_000), os.urandom(70_000), tmp_path / "x.mcap"
    kinds = [noise, *3 * [noise + noise + other]]
    by_us(path, "zstd_small", [(1, n, n, n, data) for n, data in enumerate(kinds)])

    with path.open("rb") as stream:
        assert [one.compression for one in scan(stream).chunks] == ["", "", "", "zstd"]


@pytest.mark.parametrize("length", [0, 1, 255, 256, 70_001])
def test_the_checksum_of_two_texts_is_that_of_one(length: int):
    one, other = os.urandom(20), os.urandom(length)
    found = joined_checksum(zlib.crc32(one), zlib.crc32(other), length)
    assert found == zlib.crc32(one + other)


def test_writing_does_not_wait_for_the_disk(tmp_path: Path, monkeypatch):
    """The thread that gives pages back does; the end of the file stays in memory."""
    begun, written, advised = threading.Event(), threading.Event(), []

    def advise(file: int, start: int, length: int, advice: int) -> None:
        begun.set()
        assert written.wait(60)
        advised.append((start, length, advice))

    def end() -> None:
        assert begun.wait(60)
        written.set()

    monkeypatch.setattr(write_behind, "KEPT_BYTES", 2 * CHUNK_BYTES)
    monkeypatch.setattr(write_behind, "_STEP_BYTES", CHUNK_BYTES)
    monkeypatch.setattr(os, "posix_fadvise", advise)
    path = tmp_path / "x.mcap"
    messages = [(1, number, number, number, bytes(CHUNK_BYTES)) for number in range(20)]
    by_us(path, "none", messages, before_end=end)

    assert {(start, advice) for start, _, advice in advised} == {(0, os.POSIX_FADV_DONTNEED)}
    assert CHUNK_BYTES <= advised[-1][1] <= path.stat().st_size - 2 * CHUNK_BYTES


def refuse(*words: object) -> None:
    raise OSError


@pytest.mark.parametrize("name", ["dup", "posix_fadvise"])
def test_a_file_is_whole_without_advice(tmp_path: Path, monkeypatch, name: str):
    expected = by_us(tmp_path / "small.mcap", "none", contents())
    monkeypatch.setattr(write_behind, "KEPT_BYTES", 0)
    monkeypatch.setattr(write_behind, "_STEP_BYTES", CHUNK_BYTES)
    monkeypatch.setattr(os, name, refuse)

    assert len(by_us(tmp_path / "x.mcap", "none", contents())) == len(expected)


def test_what_cannot_be_closed_is_left(tmp_path: Path):
    writer = McapStream(str(tmp_path / "x.mcap"), CHUNK_BYTES, "none")
    os.close(writer._file.fileno())
    writer.abandon()
    assert writer.closed
