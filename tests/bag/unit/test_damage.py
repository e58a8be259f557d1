"""Damaged and hostile bags: what is refused, in one sentence, and what `bag check` sees."""

from __future__ import annotations

import os
import shutil
import signal
import sqlite3
import struct
import threading
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import lz4.frame
import pytest
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from mcap.writer import Writer

from launcher.bag import check, compression, metadata
from launcher.bag import verbs as bag_verb
from launcher.bag.bag_model import BagError, Definition, Span, Topic
from launcher.bag.decode import decoder
from launcher.bag.mcap_records import HEAD, MAGIC
from launcher.bag.reader import Bag
from launcher.bag.sqlite_file import SqliteFile
from tests.support.bags import (
    counting,
    foreign_bag,
    string_cdr,
    text_of,
    write_bag,
)
from tests.support.waiting import wait_until

EVERYTHING = [f"message {n}" for n in range(95)]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_bag(tmp_path_factory.mktemp("bags") / "good", counting("/a", 95))


@pytest.fixture
def folder(whole: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(whole, tmp_path / "good"))


def storage_of(folder: Path) -> Path:
    return next(folder.glob("*.mcap"))


def texts(path: Path) -> list[str]:
    return [text_of(one.data) for one in Bag(str(path)).messages()]


def records(data: bytes) -> list[tuple[int, int, int]]:
    """(offset, opcode, length) of all records of a whole file."""
    found, offset = [], len(MAGIC)
    while offset < len(data) - len(MAGIC):
        opcode, length = HEAD.unpack_from(data, offset)
        found.append((offset, opcode, length))
        offset += HEAD.size + length
    return found


def edit(path: Path, offset: int, new: bytes) -> None:
    with path.open("r+b") as file:
        file.seek(offset)
        file.write(new)


def repaired(folder: Path) -> check.BagReport:
    check.repair(check.check(str(folder)), "jazzy")
    report = check.check(str(folder))
    assert report.is_whole, report
    return report


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


def foreign_file(path: Path, edits: Callable[[Chunk], None] | None = None) -> Path:
    """A file of another writer, without checksums of data and summary."""
    with path.open("wb") as stream:
        writer = Writer(stream, enable_crcs=False)
        writer.start("ros2")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
        channel = writer.register_channel("/a", "cdr", schema)
        for number in range(20):
            writer.add_message(channel, 10**9 + number, string_cdr(f"m{number}"), 0)
        writer.finish()
    if edits is not None:
        rewrite_chunk(path, edits)
    return path


def rewrite_chunk(path: Path, edits: Callable[[Chunk], None]) -> None:
    """Replace the first chunk by an edited one of the same length."""
    data = path.read_bytes()
    offset, _, length = next(one for one in records(data) if one[1] == Opcode.CHUNK)
    with path.open("rb") as stream:
        reader = StreamReader(stream, emit_chunks=True)
        chunk = next(one for one in reader.records if isinstance(one, Chunk))
    edits(chunk)
    builder = RecordBuilder()
    chunk.write(builder)
    new = builder.end()
    assert len(new) == HEAD.size + length
    edit(path, offset, new)


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


# ---- compressed data


def compress(data: bytes, name: str) -> bytes:
    return zstandard.compress(data) if name == "zstd" else lz4.frame.compress(data)


@pytest.mark.parametrize("name", ["zstd", "lz4"])
def test_decompression_stops_at_the_declared_size(name: str):
    bomb = compress(bytes(300 << 20), name)
    tracemalloc.start()
    with pytest.raises(ValueError, match="more than 1000 bytes"):
        compression.exactly(bomb, 1000, name)
    with pytest.raises(ValueError, match=r"it would have|it has"):
        compression.exactly(bomb[:1000], 2**62, name)
    assert tracemalloc.get_traced_memory()[1] < 20 << 20
    tracemalloc.stop()


@pytest.mark.parametrize("name", ["zstd", "lz4", ""])
@pytest.mark.parametrize("size", [0, 1, 99, 101])
def test_another_size_than_the_declared_one_is_damage(name: str, size: int):
    data = b"x" * 100
    packed = compress(data, name) if name else data
    assert compression.exactly(packed, 100, name) == data
    with pytest.raises(ValueError, match="it has"):
        compression.exactly(packed, size, name)


def test_a_chunk_that_is_larger_than_it_says(tmp_path: Path):
    def edits(chunk: Chunk) -> None:
        chunk.uncompressed_size -= 1

    path = foreign_file(tmp_path / "a.mcap", edits)
    with pytest.raises(BagError, match=r"is damaged: a chunk is damaged \(it has more than"):
        texts(path)
    assert "a chunk is damaged" in check.check(str(path)).files[0].faults[0].text


@pytest.mark.parametrize("size", [2**62, 2**40, 400 << 20])
def test_a_compressed_message_that_says_a_huge_size(size: int):
    frame = b"\x28\xb5\x2f\xfd\xe0" + struct.pack("<Q", size) + zstandard.compress(b"x")[5:]
    with pytest.raises(ValueError, match="a compressed message is damaged"):
        compression.message_decompressor()(frame)


# ---- sizes of messages


def bytes_topic(text: str, name: str = "x_msgs/msg/X") -> Topic:
    return Topic(name="/x", type=name, definition=Definition(text=text))


@pytest.mark.parametrize(
    ("text", "data"),
    [
        ("string data\n", struct.pack("<I", 7) + b"hello\0"),
        ("string data\n", struct.pack("<I", 2**32 - 1) + b"hello\0"),
        ("uint8[] data\n", struct.pack("<I", 7) + b"hello\0"),
        ("uint8[7] data\n", b"hello\0"),
        ("float64[] data\n", struct.pack("<I4xd", 2, 1.0)),
        ("float64[200000000] data\n", struct.pack("<d", 1.0)),
        ("string[] data\n", struct.pack("<I", 2**32 - 1) + b"hello\0"),
        ("x_msgs/Y[] data\n" + "=" * 80 + "\nMSG: x_msgs/Y\nint8 a\n", struct.pack("<I", 2**31)),
    ],
)
def test_what_is_longer_than_its_message_is_damage(text: str, data: bytes):
    tracemalloc.start()
    with pytest.raises(BagError, match="/x: a message is not a x_msgs/msg/X"):
        decoder(bytes_topic(text))(b"\0\1\0\0" + data)
    assert tracemalloc.get_traced_memory()[1] < 5 << 20
    tracemalloc.stop()


def nested(depth: int) -> str:
    parts = [f"MSG: x_msgs/T{n}\nx_msgs/T{n + 1} a" for n in range(depth)]
    parts.append(f"MSG: x_msgs/T{depth}\nint8 a")
    return "\n".join(["x_msgs/T0 a", *(f"{'=' * 80}\n{part}" for part in parts)])


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (nested(3000), "it is nested more than 100 levels deep"),
        ("x_msgs/X a\n", "x_msgs/X contains itself"),
        (f"x_msgs/Y a\n{'=' * 80}\nMSG: x_msgs/Y\nx_msgs/Y[] a\n", "x_msgs/Y contains itself"),
    ],
)
def test_types_that_no_message_can_have(text: str, reason: str):
    with pytest.raises(BagError) as caught:
        decoder(bytes_topic(text))
    assert caught.value.message == f"/x: the definition of x_msgs/msg/X cannot be read: {reason}"


def test_types_may_be_nested_as_deeply_as_any_real_one():
    decode = decoder(bytes_topic(nested(90)))
    value = decode(b"\0\1\0\0\5")
    for _ in range(92):
        value = value.a
    assert value == 5


# ---- SQLite


@pytest.fixture
def database(tmp_path: Path) -> Path:
    messages: list[tuple[str, str, int, object]] = [
        ("/a", "std_msgs/msg/String", 10**18 + n, {"data": str(n)}) for n in range(3)
    ]
    return next(foreign_bag(tmp_path / "sql", messages).glob("*.db3"))


def execute(path: Path, *statements: str) -> None:
    connection = sqlite3.connect(path)
    for statement in statements:
        connection.execute(statement)
    connection.commit()
    connection.close()


ENDLESS = (
    "WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n) SELECT x AS id, "
    "1 AS topic_id, x AS timestamp, x'00' AS data FROM n"
)


@pytest.mark.parametrize(
    ("statements", "text"),
    [
        (
            ("ALTER TABLE messages RENAME TO old", f"CREATE VIEW messages AS {ENDLESS}"),
            "messages is a view, not a table",
        ),
        (
            (
                "ALTER TABLE messages RENAME TO old",
                "CREATE VIRTUAL TABLE Messages USING fts4(id, topic_id, timestamp, data)",
            ),
            "Messages is a virtual, not a table",
        ),
        (
            (
                "ALTER TABLE messages RENAME TO old",
                "CREATE TABLE messages(id, topic_id, timestamp, data AS (zeroblob(1000000000)))",
            ),
            "messages.data is computed",
        ),
    ],
)
def test_tables_that_compute_what_they_have(database: Path, statements: tuple[str, ...], text: str):
    execute(database, *statements)
    with pytest.raises(BagError) as caught:
        Bag(str(database))
    assert caught.value.message == f"{database} is no bag: {text}"


@pytest.mark.parametrize(
    ("statement", "text"),
    [
        ("UPDATE messages SET data = 'text'", "a message has no bytes"),
        ("UPDATE messages SET timestamp = 'soon'", "a message has no time"),
        ("UPDATE messages SET timestamp = -5", "a message has an impossible time"),
        ("UPDATE messages SET topic_id = 77", "a message belongs to the unknown topic 77"),
        ("UPDATE messages SET topic_id = x'00'", "a message belongs to the unknown topic"),
    ],
)
def test_rows_of_other_types(database: Path, statement: str, text: str):
    execute(database, statement)
    with pytest.raises(BagError, match=text):
        list(Bag(str(database)).messages())


def endless(database: Path) -> SqliteFile:
    """A file whose query of all messages takes for ever."""
    file = SqliteFile(str(database), str(database))
    execute(database, "ALTER TABLE messages RENAME TO old", f"CREATE VIEW messages AS {ENDLESS}")
    return file


def test_a_signal_ends_a_long_query(database: Path):
    def interrupted() -> bool:
        signal.raise_signal(signal.SIGINT)  # as it would be handled while SQLite is at work
        return False

    with pytest.raises(KeyboardInterrupt):
        list(endless(database).messages(None, Span(2**62, 2**62 + 1), interrupted))


def test_a_long_query_in_a_thread_ends_when_it_is_stopped(database: Path, tmp_path: Path):
    stop = threading.Event()
    asked = threading.Event()

    def stopped() -> bool:
        asked.set()
        return stop.is_set()

    found: list[object] = []

    def read() -> None:
        file = endless(database)
        found.extend(file.messages(None, Span(2**62, 2**62 + 1), stopped))

    thread = threading.Thread(target=read)
    thread.start()
    wait_until(asked.is_set, "the query to run")
    stop.set()
    thread.join(60)
    assert not thread.is_alive()
    assert found == []


# ---- texts


@pytest.mark.parametrize(
    "text", ["nonsense", "[1, 2]", "{a: b}", "- {depth: much}", "- {deadline: 5}", "[" * 50_000]
)
def test_qos_that_is_no_list_of_mappings_is_a_note(tmp_path: Path, text: str):
    path = tmp_path / "a.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
        channel = writer.register_channel("/a", "cdr", schema, {"offered_qos_profiles": text})
        writer.add_message(channel, 1, string_cdr("x"), 0)
        writer.finish()
    bag = Bag(str(path))
    assert bag.notes[0].startswith("/a: its QoS profiles cannot be read: ")
    assert [len(list(bag.messages())), bag.topics[0].qos] == [1, ()]
    report = check.check(str(path))
    assert report.is_whole
    assert report.files[0].notes[0].startswith("/a: its QoS profiles cannot be read: ")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("message_count: 95", f"message_count: {2**64 - 1}"),
        ("nanoseconds_since_epoch: 1", "nanoseconds_since_epoch: 99"),
        ("nanoseconds: 9", "nanoseconds: -9"),
        ("name: /a", "name: [/a]"),
        ("name: /a", 'name: "\\uD800"'),
        ("reliability: reliable", "reliability: [[], []]"),
        ("version: 9", "version: new"),
        ("custom_data:", "custom_data: {a: &a [x, x], b: [*a, *a]}\n  was:"),
        ("- good_0.mcap", '- "a\\0b"'),
        ("- good_0.mcap", "- &a [*a]"),
    ],
)
def test_metadata_that_no_bag_has(folder: Path, old: str, new: str):
    path = folder / metadata.FILE
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(BagError) as caught:
        Bag(str(folder))
    assert str(path) in caught.value.message
    assert "bag check --repair" in (caught.value.hint or "")
    repaired(folder)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("[" * 50_000, "more than 100 levels"),
        ("a: [" * 50_000, "more than 100 levels"),
        ("x: " + "9" * 100_000, "a number of more than 1000 characters"),
        ("[" + "x, " * (6 << 20) + "]", "it has more than 16 MiB"),
        (
            "\n".join([*(f"a{n}: &a{n} [{f'*a{n - 1}, ' * 10}]" for n in range(1, 9))]).replace(
                "*a0", "x"
            ),
            "more than 1000000 values",
        ),
    ],
)
def test_yaml_without_bounds(folder: Path, text: str, reason: str):
    (folder / metadata.FILE).write_text(text)
    with pytest.raises(BagError, match=reason):
        Bag(str(folder))
    repaired(folder)


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


# ---- files that are none


POINTER = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n"


@pytest.mark.parametrize("name", ["a.mcap", "a.db3", "a.mcap.zstd", "a.db3.zstd"])
def test_a_pointer_of_git_lfs_is_called_that(tmp_path: Path, name: str):
    path = tmp_path / name
    path.write_text(POINTER)
    for read in (Bag, check.check):
        with pytest.raises(BagError) as caught:
            read(str(path))
        assert caught.value.message == f"{path} is a pointer of Git LFS in place of the file"
        assert "git lfs pull" in (caught.value.hint or "")


def test_metadata_that_are_a_pointer_of_git_lfs(folder: Path):
    (folder / metadata.FILE).write_text(POINTER)
    with pytest.raises(BagError, match=r"metadata.yaml is a pointer of Git LFS"):
        Bag(str(folder))


def test_a_pipe_is_no_bag(tmp_path: Path):
    os.mkfifo(tmp_path / "a.mcap")
    with pytest.raises(BagError, match=r"a\.mcap is not a file"):
        Bag(str(tmp_path / "a.mcap"))


@pytest.mark.parametrize(
    ("name", "contents", "text"),
    [
        ("a.db3", b"", "is empty"),
        ("a.db3", b"no database", "file is not a database"),
        ("a.mcap", b"no bag at all", "it is not an MCAP file"),
        ("a.txt", b"no bag at all", "is not an MCAP file"),
    ],
)
def test_no_repair_of_what_is_no_bag(tmp_path: Path, capsys, name: str, contents: bytes, text: str):
    path = tmp_path / name
    path.write_bytes(contents)
    assert bag_verb.main(["check", str(path)]) == 1
    found = capsys.readouterr()
    assert text in found.out
    assert not found.err
    with pytest.raises(BagError) as caught:
        Bag(str(path))
    assert "recover" not in caught.value.render()


def test_a_repair_that_cannot_be_written_names_the_file(tmp_path: Path):
    path = tmp_path / ("x" * 248 + ".mcap")  # its name has no room for .tmp
    path.write_bytes(
        next(write_bag(tmp_path / "b", counting("/a", 95)).glob("*.mcap")).read_bytes()
    )
    edit(path, len(MAGIC) + HEAD.size, b"\xff")
    with pytest.raises(OSError, match="File name too long") as caught:
        check.repair(check.check(str(path)), "jazzy")
    assert caught.value.filename == str(path)


def test_a_definition_that_cannot_be_read_prints_nothing(capfd):
    topic = bytes_topic("string 1dat\n")
    with pytest.raises(BagError, match=r"cannot be read: '1dat' is an invalid .*'string 1dat'"):
        decoder(topic)
    assert capfd.readouterr() == ("", "")
