"""`bag convert` to CSV and JSON lines, for which messages are decoded."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import pytest

from launcher.bag.bag_model import BagError, Definition, Message, Topic
from launcher.bag.writer import BagWriter
from tests.support.bags import (
    START_NS,
    contents,
    convert,
    counting,
    imu_bag,
    typed_bag,
    write_bag,
)


def test_csv_has_a_column_for_each_field(tmp_path: Path):
    folder = imu_bag(tmp_path / "db")
    convert(folder, "-o", tmp_path / "out.csv")
    rows = list(csv.DictReader(io.StringIO((tmp_path / "out.csv").read_text())))
    assert len(rows) == 4
    first, last = rows[0], rows[-1]
    assert first["time"] == "1700000000.000000000"
    assert first["topic"] == "/imu"
    assert (first["header.stamp.sec"], first["header.frame_id"]) == ("5", 'a "b", ü')
    assert json.loads(first["orientation_covariance"]) == list(range(9))
    assert (first["angular_velocity.y"], first["angular_velocity.z"]) == ("nan", "inf")
    assert rows[1]["angular_velocity.x"] == "0.5"
    assert (last["data"], last["orientation.w"], first["data"]) == ("t", "", "")


def test_csv_of_fields(tmp_path: Path):
    folder = imu_bag(tmp_path / "db")
    words = ["--field", "orientation_covariance[2]", "--field", "header.stamp"]
    convert(folder, "-o", tmp_path / "out.csv", "--topics", "/imu", *words)
    lines = (tmp_path / "out.csv").read_text().splitlines()
    assert lines[0] == "time,orientation_covariance[2],header.stamp"
    assert lines[1] == '1700000000.000000000,2.0,"{""sec"": 5, ""nanosec"": 7}"'


def test_json_lines(tmp_path: Path, capsys):
    folder = imu_bag(tmp_path / "db")
    convert(folder, "-o", "-", "--to", "jsonl")
    out, err = capsys.readouterr()
    first, *_, last = map(json.loads, out.splitlines())
    assert first["topic"] == "/imu"
    assert first["time_ns"] == first["publish_ns"] == START_NS
    assert first["message"]["angular_velocity"] == {"x": 0.0, "y": "nan", "z": "inf"}
    assert last["message"] == {"data": "t"}
    assert "4 messages of 2 topics" in err
    convert(folder, "-o", tmp_path / "o.jsonl", "-e", "imu", "--field", "header.stamp.sec")
    documents = map(json.loads, (tmp_path / "o.jsonl").read_text().splitlines())
    assert [one["message"] for one in documents] == [{"header.stamp.sec": 5}] * 3


@pytest.mark.parametrize("field", ["dat", "data.x", "data[0"])
@pytest.mark.parametrize("kind", ["csv", "jsonl"])
def test_fields_that_are_not_there(tmp_path: Path, field: str, kind: str):
    folder = write_bag(tmp_path / "b", counting("/a", 1))
    with pytest.raises(BagError, match=r"Invalid field"):
        convert(folder, "-o", tmp_path / f"x.{kind}", "--field", field)
    assert not (tmp_path / f"x.{kind}").exists()


@pytest.mark.parametrize(
    ("topic", "text"),
    [
        (Topic(name="/a", type="x_msgs/msg/X"), "the bag has no definition of x_msgs/msg/X"),
        (Topic(name="/a", type="std_msgs/msg/String", serialization="json"), "messages in 'json'"),
        (
            Topic(name="/a", type="x/msg/X", definition=Definition(text="wstring s\n")),
            "x/msg/X has a field of type wstring, which cannot be decoded",
        ),
        (
            Topic(
                name="/a",
                type="x/msg/X",
                definition=Definition(text="module x;", encoding="ros2idl"),
            ),
            "is defined in 'ros2idl'",
        ),
        (
            Topic(name="/a", type="x/msg/X", definition=Definition(text="float64[99] a\n")),
            "a message is not a x/msg/X",
        ),
        (
            Topic(name="/a", type="x/msg/X", definition=Definition(text="what is this\n")),
            "the definition of x/msg/X cannot be read",
        ),
    ],
)
def test_what_cannot_be_decoded(tmp_path: Path, topic: Topic, text: str):
    folder = typed_bag(tmp_path / "b", topic)
    with pytest.raises(BagError, match=text):
        convert(folder, "-o", tmp_path / "x.csv")
    assert not (tmp_path / "x.csv").exists()
    convert(folder, "-o", tmp_path / "copy")
    assert len(contents(tmp_path / "copy")) == 1


def test_char_is_unsigned_and_durations_signed(tmp_path: Path):
    text = "char c\nbuiltin_interfaces/Duration d\n"
    topic = Topic(name="/a", type="x/msg/X", definition=Definition(text=text))
    writer = BagWriter(str(tmp_path / "b"))
    writer.add_topic(topic)
    data = b"\0\1\0\0\xff\0\0\0\xff\xff\xff\xff\1\0\0\0"
    writer.write(Message("/a", 1, 1, 0, data))
    writer.close()
    convert(tmp_path / "b", "-o", tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text().splitlines() == [
        "time,c,d.sec,d.nanosec",
        "0.000000001,255,-1,1",
    ]


def test_messages_without_fields(tmp_path: Path):
    topic = Topic(name="/e", type="std_msgs/msg/Empty", definition=Definition(text=""))
    writer = BagWriter(str(tmp_path / "b"))
    writer.add_topic(topic)
    writer.write(Message("/e", 10**9, 10**9, 0, b"\0\1\0\0\0"))
    writer.close()
    convert(tmp_path / "b", "-o", tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text() == "time\n1.000000000\n"
    convert(tmp_path / "b", "-o", tmp_path / "x.jsonl")
    assert json.loads((tmp_path / "x.jsonl").read_text())["message"] == {}
