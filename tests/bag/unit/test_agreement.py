"""A topic that has several types, definitions or encodings in one bag."""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import pytest
from mcap.writer import Writer

from launcher.bag import check, metadata
from launcher.bag import verbs as bag_verb
from launcher.bag.bag_model import BagError
from launcher.bag.reader import Bag
from tests.support.bags import (
    START_NS,
    contents,
    convert,
    counting,
    string_cdr,
    times_of,
    write_bag,
)

INT32 = b"\0\1\0\0\1\0\0\0"
STRING_TEXT = "string data\n"
SECOND = 10**9


class Channel(NamedTuple):
    """A channel of a file of tests; message k comes at `first_s` + k seconds."""

    type: str = "std_msgs/msg/String"
    text: str = STRING_TEXT
    data: bytes = string_cdr("x")
    encoding: str = "cdr"
    count: int = 5
    first_s: int = 0
    language: str = "ros2msg"
    custom: str = ""


INTEGERS = Channel("std_msgs/msg/Int32", "int32 data\n", INT32, count=3, first_s=7)
ANOTHER_DEFINITION = Channel(text="int32 data\n", data=INT32, count=3)
JSON = Channel(encoding="json", data=b"{}", count=3)


def mcap(path: Path, channels: Sequence[Channel], *, cut: bool = False) -> Path:
    """A file with all of these as the topic /a."""
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2")
        for one in channels:
            schema = writer.register_schema(one.type, one.language, one.text.encode())
            channel = writer.register_channel("/a", one.encoding, schema, {"custom": one.custom})
            for k in range(one.count):
                time_ns = START_NS + (one.first_s + k) * SECOND
                writer.add_message(channel, time_ns, one.data, time_ns)
        writer.finish()
    if cut:
        path.write_bytes(path.read_bytes()[:-9])
    return path


def data_of(bag: Bag) -> set[bytes]:
    return {message.data for message in bag.messages()}


@pytest.mark.parametrize("cut", [False, True])
@pytest.mark.parametrize(
    ("other", "text"),
    [
        (INTEGERS, "3 messages of std_msgs/msg/Int32 (cdr) are left out"),
        (ANOTHER_DEFINITION, "3 messages of another definition of std_msgs/msg/String are left"),
        (JSON, "3 messages of std_msgs/msg/String (json) are left out"),
        (INTEGERS._replace(count=1), "1 message of std_msgs/msg/Int32 (cdr) is left out"),
    ],
)
def test_messages_of_other_channels_are_left_out_and_named(
    tmp_path: Path, other: Channel, text: str, cut: bool
):
    bag = Bag(str(mcap(tmp_path / "b.mcap", [Channel(), other, Channel(custom="x")], cut=cut)))
    assert data_of(bag) == {string_cdr("x")}
    assert bag.extent.counts == {"/a": 10}
    assert bag.left_out == {"/a": other.count}
    assert (bag.extent.start_ns, bag.extent.duration_ns) == (START_NS, 4 * SECOND)
    assert {topic: len(times) for topic, times in times_of(bag).items()} == {"/a": 10}
    notes = [note for note in bag.notes if note.startswith("/a is std_msgs/msg/String (cdr); ")]
    assert len(notes) == 1
    assert text in notes[0]


@pytest.mark.parametrize(
    "other",
    [
        Channel(custom="only the metadata differ"),
        Channel(type="std_msgs/String"),
        Channel(text=""),
        Channel(text="# what it says\nstring   data # text\n"),
        Channel(text="module std_msgs {};", language="ros2idl"),
        INTEGERS._replace(count=0),
    ],
)
def test_what_is_or_may_be_the_same_is_merged(tmp_path: Path, other: Channel):
    bag = Bag(str(mcap(tmp_path / "b.mcap", [Channel(), other])))
    assert bag.extent.counts == {"/a": 5 + other.count}
    assert not bag.notes


def test_the_order_of_the_needed_types_is_no_difference(tmp_path: Path):
    parts = ["B b\nC c\n", "MSG: x_msgs/B\nint32 b\n", "MSG: x_msgs/msg/C\nint32 c\n"]
    line = f"{'=' * 80}\n"
    one = Channel("x_msgs/msg/A", line.join(parts))
    other = one._replace(text=line.join([parts[0], parts[2], parts[1]]))
    assert not Bag(str(mcap(tmp_path / "b.mcap", [one, other]))).left_out
    fewer = one._replace(text=line.join(parts[:2]))
    assert Bag(str(mcap(tmp_path / "c.mcap", [one, fewer]))).left_out == {"/a": 5}


def test_the_type_is_that_of_the_first_messages(tmp_path: Path):
    folder = tmp_path / "b"
    folder.mkdir()
    mcap(folder / "b_0.mcap", [Channel(count=0)])
    mcap(folder / "b_1.mcap", [Channel(count=0), INTEGERS, Channel()])
    mcap(folder / "b_2.mcap", [Channel(), INTEGERS])
    bag = Bag(str(folder))
    assert [topic.type for topic in bag.topics] == ["std_msgs/msg/Int32"]
    assert data_of(bag) == {INT32}
    assert bag.left_out == {"/a": 10}
    assert [note.partition(":")[0] for note in bag.notes[1:]] == ["b_1.mcap", "b_2.mcap"]


def test_rows_of_one_name_in_a_database(tmp_path: Path):
    database = sqlite3.connect(tmp_path / "b.db3")
    database.executescript(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT,"
        " serialization_format TEXT, offered_qos_profiles TEXT);"
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER,"
        " data BLOB);"
        "INSERT INTO topics VALUES (1, '/a', 'std_msgs/msg/String', 'cdr', ''),"
        " (2, '/a', 'std_msgs/msg/Int32', 'cdr', ''), (3, '/a', 'std_msgs/String', 'cdr', '');"
    )
    rows = [(1, 5, string_cdr("x")), (2, 9, INT32), (3, 6, string_cdr("x"))]
    database.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", rows)
    database.commit()
    database.close()
    bag = Bag(str(tmp_path / "b.db3"))
    assert data_of(bag) == {string_cdr("x")}
    assert bag.extent.counts == {"/a": 2}
    assert times_of(bag) == {"/a": [5, 6]}
    assert bag.left_out == {"/a": 1}
    assert "std_msgs/msg/Int32" in bag.notes[0]
    (report,) = check.check(str(tmp_path / "b.db3")).files
    assert report.conflicts == bag.notes


def test_check_says_it_and_offers_no_repair(tmp_path: Path, capsys):
    path = mcap(tmp_path / "b.mcap", [Channel(), INTEGERS])
    before = path.read_bytes()
    report = check.check(str(path))
    assert not report.is_whole
    assert not report.is_repairable
    for words in (["check"], ["check", "--repair"]):
        assert bag_verb.main([*words, str(path)]) == 1
        found = capsys.readouterr()
        assert "3 messages of std_msgs/msg/Int32 (cdr) are left out" in found.out
        assert not found.err
    assert path.read_bytes() == before


def test_a_copy_has_what_agrees_and_is_not_called_alike(tmp_path: Path, capsys):
    path = mcap(tmp_path / "b.mcap", [Channel(), INTEGERS])
    convert(path, "-o", tmp_path / "c")
    assert "wrote" in capsys.readouterr().out
    assert contents(tmp_path / "c") == [("/a", "x")] * 5
    assert bag_verb.main(["compare", str(path), str(tmp_path / "c")]) == 1
    assert "3 messages in A and 0 in B are of another type" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("other", "merging", "comparing"),
    [
        (ANOTHER_DEFINITION, "is not defined in the same way", "is not defined in the same way"),
        (JSON, "/a is in 'cdr' in", "messages are in 'cdr' in A, in 'json' in B"),
    ],
)
def test_two_bags_that_disagree(tmp_path: Path, capsys, other, merging: str, comparing: str):
    a = mcap(tmp_path / "a.mcap", [Channel(count=3)])
    b = mcap(tmp_path / "b.mcap", [other._replace(data=string_cdr("x"))])
    with pytest.raises(BagError, match=merging):
        convert(a, b, "-o", tmp_path / "c")
    assert bag_verb.main(["compare", str(a), str(b)]) == 1
    assert comparing in capsys.readouterr().out


def test_metadata_with_another_type_than_the_files(tmp_path: Path, capsys):
    folder = write_bag(tmp_path / "b", counting("/a", 3))
    file = folder / metadata.FILE
    file.write_text(file.read_text().replace("std_msgs/msg/String", "std_msgs/msg/Int32"))
    bag = Bag(str(folder))
    assert [topic.type for topic in bag.topics] == ["std_msgs/msg/String"]
    sentence = (
        "metadata.yaml says that /a is std_msgs/msg/Int32; the files have std_msgs/msg/String"
    )
    assert bag.notes == [sentence]
    assert check.check(str(folder)).problems == [sentence]
    assert bag_verb.main(["check", "--repair", str(folder)]) == 0
    assert not Bag(str(folder)).notes
