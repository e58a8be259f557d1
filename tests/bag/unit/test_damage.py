"""Damaged MCAP files: what is refused, in one sentence, and what `bag check` sees."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from mcap.writer import Writer

from launcher.bag import check
from launcher.bag.bag_model import BagError
from launcher.bag.mcap.records import HEAD, MAGIC
from launcher.bag.reader import Bag
from tests.bag.unit.damaged_files import (
    EVERYTHING,
    edit,
    foreign_file,
    records,
    repaired,
    storage_of,
    texts,
)
from tests.support.bags import counting, string_cdr, text_of, write_bag

# ---- the end of an MCAP file


@pytest.mark.parametrize(
    ("field", "value"),
    [(0, 2**64 - 1), (0, 10**9), (0, 1), (0, 4000), (8, 2**64 - 1), (16, 7)],
)
def test_a_footer_that_leads_nowhere(folder: Path, field: int, value: int):
    file = storage_of(folder)
    footer = len(file.read_bytes()) - len(MAGIC) - 20
    edit(file, footer + field, struct.pack("<I" if field == 16 else "<Q", value))
    assert texts(folder) == EVERYTHING
    bag = Bag(str(folder))
    assert "bag check --repair" in bag.notes[0]
    (fault,) = check.check(str(folder)).files[0].faults
    assert not fault.lost
    assert "footer" in fault.text or "summary" in fault.text
    repaired(folder)
    assert texts(folder) == EVERYTHING
    assert not Bag(str(folder)).notes


def test_a_summary_of_channels_that_it_lacks(folder: Path):
    file = storage_of(folder)
    data = file.read_bytes()
    (*_, channel) = (offset for offset, opcode, _ in records(data) if opcode == Opcode.CHANNEL)
    edit(file, channel + HEAD.size, struct.pack("<H", 77))
    edit(file, len(data) - len(MAGIC) - 4, bytes(4))  # no checksum
    assert texts(folder) == EVERYTHING


def test_bytes_behind_the_end(folder: Path):
    file = storage_of(folder)
    file.write_bytes(file.read_bytes() + b"more" + MAGIC)
    assert not check.check(str(folder)).is_whole
    repaired(folder)
    assert texts(folder) == EVERYTHING


# ---- what `bag check` sees


def test_the_checksum_of_the_data_is_that_of_the_mcap_library(folder: Path):
    with storage_of(folder).open("rb") as stream:
        ends = [
            one.data_section_crc
            for one in StreamReader(stream, validate_crcs=True).records
            if type(one).__name__ == "DataEnd"
        ]
    assert len(ends) == 1
    assert ends[0] != 0


@pytest.mark.parametrize("cut", [True, False])
def test_repaired_files_have_the_checksum(folder: Path, cut: bool):
    file = storage_of(folder)
    if cut:
        file.write_bytes(file.read_bytes()[:-9])
    else:
        edit(file, len(MAGIC) + HEAD.size, b"\xff")
    repaired(folder)
    with file.open("rb") as stream:
        assert len(list(StreamReader(stream, validate_crcs=True).records)) > 95


@pytest.mark.parametrize("part", range(60))
def test_a_flipped_byte_anywhere_is_seen_and_repaired(folder: Path, part: int):
    file = storage_of(folder)
    data = file.read_bytes()
    offset = (len(data) - 1) * part // 59
    edit(file, offset, bytes([data[offset] ^ 0x10]))
    report = check.check(str(folder))
    assert not report.files[0].is_whole, offset
    before = report.extent.total
    repaired(folder)
    assert len(texts(folder)) >= before >= 85
    assert set(texts(folder)) <= set(EVERYTHING)


@pytest.mark.parametrize("kind", [Opcode.CHUNK, Opcode.MESSAGE_INDEX, Opcode.METADATA])
@pytest.mark.parametrize("part", ["opcode", "length", "contents"])
def test_a_mutated_record_of_the_data(folder: Path, kind: Opcode, part: str):
    file = storage_of(folder)
    data = file.read_bytes()
    offset, _, length = next(one for one in records(data) if one[1] == kind)
    place = {"opcode": offset, "length": offset + 2, "contents": offset + HEAD.size + length - 3}
    edit(file, place[part], bytes([data[place[part]] ^ 0x08]))
    assert not check.check(str(folder)).is_whole
    repaired(folder)
    assert len(texts(folder)) >= 85
    assert list(folder.glob("*.damaged"))


def test_a_file_without_checksums_is_whole(tmp_path: Path):
    assert check.check(str(foreign_file(tmp_path / "a.mcap"))).is_whole


def test_the_times_in_the_head_of_a_chunk(tmp_path: Path):
    def edits(chunk: Chunk) -> None:
        chunk.message_end_time += 1

    path = foreign_file(tmp_path / "a.mcap", edits)
    (fault,) = check.check(str(path)).files[0].faults
    assert fault.text == "the head of a chunk does not fit its messages"


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        (Opcode.MESSAGE_INDEX, "an index does not fit the messages of its chunk"),
        (Opcode.STATISTICS, "its summary"),
        (Opcode.CHUNK_INDEX, "its summary"),
    ],
)
def test_indexes_that_do_not_fit_without_a_checksum(tmp_path: Path, kind: Opcode, text: str):
    path = foreign_file(tmp_path / "a.mcap")
    offset = next(offset for offset, opcode, _ in records(path.read_bytes()) if opcode == kind)
    place = offset + HEAD.size + (6 if kind == Opcode.MESSAGE_INDEX else 0)
    edit(path, place, bytes([path.read_bytes()[place] ^ 1]))
    faults = check.check(str(path)).files[0].faults
    assert text in faults[0].text


@pytest.mark.parametrize("offset", [2**64 - 1, 2**40, 100])
def test_an_index_of_a_chunk_that_is_elsewhere(tmp_path: Path, offset: int):
    path = foreign_file(tmp_path / "a.mcap")
    index = next(at for at, opcode, _ in records(path.read_bytes()) if opcode == Opcode.CHUNK_INDEX)
    edit(path, index + HEAD.size + 16, struct.pack("<Q", offset))
    with pytest.raises(BagError, match=r"a\.mcap is damaged"):
        texts(path)
    assert not check.check(str(path)).is_whole
    check.repair(check.check(str(path)), "jazzy")
    assert texts(path) == [f"m{number}" for number in range(20)]


def test_an_index_of_a_channel_that_there_is_not(tmp_path: Path):
    path = foreign_file(tmp_path / "a.mcap")
    data = path.read_bytes()
    index = next(at for at, opcode, _ in records(data) if opcode == Opcode.MESSAGE_INDEX)
    edit(path, index + HEAD.size, struct.pack("<H", 255))
    path.write_bytes(path.read_bytes()[:-9])  # its recorder was killed
    found = Bag(str(path)).messages(["/a"])
    assert [text_of(one.data) for one in found] == [f"m{number}" for number in range(20)]


def test_messages_that_are_in_no_chunk_are_read_and_repaired(tmp_path: Path):
    path = tmp_path / "a.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream, use_chunking=False)
        writer.start("ros2")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
        channel = writer.register_channel("/a", "cdr", schema)
        for number in (2, 0, 1):
            writer.add_message(channel, number, string_cdr(f"m{number}"), 0)
        writer.finish()
    assert texts(path) == ["m0", "m1", "m2"]
    edit(path, len(MAGIC) + HEAD.size, b"\xff")
    check.repair(check.check(str(path)), "jazzy")
    assert check.check(str(path)).is_whole
    assert texts(path) == ["m0", "m1", "m2"]


def test_a_recorder_killed_between_two_indexes_loses_no_topic(tmp_path: Path):
    both = sorted(counting("/a", 5) + counting("/b", 5), key=lambda one: one.log_ns)
    folder = write_bag(tmp_path / "good", both)
    file = storage_of(folder)
    data = file.read_bytes()
    ends = [
        offset + HEAD.size + length
        for offset, opcode, length in records(data)
        if opcode == Opcode.MESSAGE_INDEX
    ]
    file.write_bytes(data[: ends[0] + 5])
    repaired(folder)
    with file.open("rb") as stream:
        found = [channel.topic for _, channel, _ in make_reader(stream).iter_messages("/b")]
    assert found == ["/b"] * 5


def test_impossible_times_of_messages_are_damage(tmp_path: Path):
    path = tmp_path / "a.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
        channel = writer.register_channel("/a", "cdr", schema)
        writer.add_message(channel, 2**64 - 1, string_cdr("x"), 0)
        writer.finish()
    bag = Bag(str(path))
    assert list(bag.messages()) == []
    assert "impossible time" in check.check(str(path)).files[0].faults[0].text


def test_a_repair_that_cannot_be_written_names_the_file(tmp_path: Path):
    path = tmp_path / ("x" * 248 + ".mcap")  # its name has no room for .tmp
    path.write_bytes(
        next(write_bag(tmp_path / "b", counting("/a", 95)).glob("*.mcap")).read_bytes()
    )
    edit(path, len(MAGIC) + HEAD.size, b"\xff")
    with pytest.raises(OSError, match="File name too long") as caught:
        check.repair(check.check(str(path)), "jazzy")
    assert caught.value.filename == str(path)
