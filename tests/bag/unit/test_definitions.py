"""Types as other recorders write them, and topics that nobody can decode, through all verbs."""

from __future__ import annotations

import csv
import json
import sqlite3
import struct
from pathlib import Path

import pytest
from rosbags.rosbag2 import Reader

from launcher.bag import verbs as bag_verb
from launcher.bag.bag_model import BagError, Definition, Message, Topic
from launcher.bag.reader import Bag
from launcher.bag.writer import BagWriter
from tests.support.bags import (
    START_NS,
    agreed_counts,
    convert,
    counting,
    foreign_bag,
    message,
    string_topic,
)

LINE = "=" * 80
SET_BOOL = "bool data # on\n---\nbool success\nstring message\n"
EVENTS = "/switch/_service_event"


def event_cdr(number: int) -> bytes:
    """A `SetBool_Event`: a response that was sent, `{success: true, message: "no"}`."""
    head = struct.pack("<4sB3xiI16s4xq", b"\0\1\0\0", 2, 5, 7, bytes(range(16)), number)
    return head + struct.pack("<IIB3xI", 0, 1, 1, 3) + b"no\0"


def event_topic(text: str, encoding: str, type_name: str = "std_srvs/srv/SetBool") -> Topic:
    definition = Definition(text=text, encoding=encoding)
    return Topic(name=EVENTS, type=f"{type_name}_Event", definition=definition)


def bag_with(folder: Path, topic: Topic, data: bytes) -> Path:
    """A bag with two messages of this topic, and two texts in `/a`."""
    writer = BagWriter(str(folder))
    writer.add_topic(string_topic("/a"))
    writer.add_topic(topic)
    for n in range(2):
        writer.write(message("/a", n, f"text {n}"))
        writer.write(Message(topic.name, START_NS + n, START_NS + n, 0, data))
    writer.close()
    return folder


def printed(capsys: pytest.CaptureFixture[str], *words: object, code: int = 0) -> tuple[str, str]:
    assert bag_verb.main([*map(str, words)]) == code
    return tuple(capsys.readouterr())


@pytest.mark.parametrize("encoding", ["unknown", "ros2msg"])
@pytest.mark.parametrize("head", ["", f"{LINE}\nSRV: std_srvs/srv/SetBool\n"])
def test_events_with_the_text_of_the_srv(tmp_path: Path, capsys, encoding: str, head: str):
    # of a type that is not installed
    topic = event_topic(head + SET_BOOL, encoding, "my_srvs/srv/SetBool")
    bag = bag_with(tmp_path / "b", topic, event_cdr(9))
    out, err = printed(capsys, "convert", bag, "-o", "-", "--to", "jsonl", "--topics", EVENTS)
    first = json.loads(out.splitlines()[0])["message"]
    assert first["info"]["stamp"] == {"sec": 5, "nanosec": 7}
    assert first["info"]["sequence_number"] == 9
    assert (first["request"], first["response"]) == ([], [{"success": True, "message": "no"}])
    assert "2 messages of 1 topic" in err
    assert "left out" not in err
    convert(bag, "-o", tmp_path / "copy")
    assert agreed_counts(tmp_path / "copy") == {"/a": 2, EVENTS: 2}
    (out, _) = printed(capsys, "info", "-v", bag)
    assert "Service: /switch | Type: my_srvs/srv/SetBool | Request Count: 0 | Response" in out


def test_events_with_types_in_their_parts(tmp_path: Path, capsys):
    sections = ("SRV: my/srv/Do\nOwn[] own\n---\nother/Two two", "MSG: my/Own\nint8 x")
    text = "\n".join(f"{LINE}\n{one}" for one in (*sections, "MSG: other/Two\nint8 y\n"))
    topic = event_topic(text, "ros2msg", "my/srv/Do")
    head = struct.pack("<4sB3xiI16s4xq", b"\0\1\0\0", 1, 5, 7, bytes(16), 3)
    data = head + struct.pack("<IIbb2xIb", 1, 2, -3, -4, 1, -5)
    bag = bag_with(tmp_path / "b", topic, data)
    out, _ = printed(capsys, "convert", bag, "-o", "-", "--to", "jsonl", "--topics", EVENTS)
    found = json.loads(out.splitlines()[0])["message"]
    assert found["request"] == [{"own": [{"x": -3}, {"x": -4}]}]
    assert found["response"] == [{"two": {"y": -5}}]


GOAL_EVENT = """\
my/Do_It_SendGoal_Request[<=1] request
my/Do_It_SendGoal_Response[<=1] response
{line}
MSG: my/Do_It_SendGoal_Request
Do_It_Goal goal
{line}
MSG: my/Do_It_Goal
int8 A_ONE=1
int8 order
{line}
MSG: my/Do_It_SendGoal_Response
bool accepted
"""


def test_events_of_actions(tmp_path: Path, capsys):
    name = f"/do/_action/send_goal{EVENTS[len('/switch') :]}"
    definition = Definition(text=GOAL_EVENT.format(line=LINE))
    topic = Topic(name=name, type="my/action/Do_It_SendGoal_Event", definition=definition)
    bag = bag_with(tmp_path / "b", topic, struct.pack("<4sIb3xI", b"\0\1\0\0", 1, -4, 0))
    out, err = printed(capsys, "convert", bag, "-o", "-", "--to", "jsonl", "--topics", name)
    assert "left out" not in err
    first = json.loads(out.splitlines()[0])["message"]
    assert first == {"request": [{"goal": {"order": -4}}], "response": []}


def test_a_type_that_is_missing_is_called_by_its_name(tmp_path: Path, capsys):
    definition = Definition(text="my/Do_It_Goal goal\n")
    topic = Topic(name="/x", type="my/msg/X", definition=definition)
    bag = bag_with(tmp_path / "b", topic, b"\0\1\0\0\4\0\0\0")
    _, err = printed(capsys, "convert", bag, "-o", tmp_path / "x.csv")
    assert "there is no definition of my/Do_It_Goal" in err


@pytest.mark.parametrize("encoding", ["unknown", "ros2idl"])
def test_a_definition_that_is_none_is_that_of_the_installed_type(tmp_path: Path, encoding: str):
    known = string_topic("/b")
    topic = Topic(
        name="/b",
        type=known.type,
        type_hash=known.type_hash,
        definition=Definition(text="module std_msgs;", encoding=encoding),
    )
    bag = bag_with(tmp_path / "b", topic, counting("/b", 1)[0].data)
    convert(bag, "-o", tmp_path / "x.csv", "--topics", "/b")
    assert (tmp_path / "x.csv").read_text().count("message 0") == 2
    other = Topic(name="/b", type=known.type, type_hash="RIHS01_00", definition=topic.definition)
    bag = bag_with(tmp_path / "other", other, counting("/b", 1)[0].data)
    with pytest.raises(BagError, match=f"is defined in '{encoding}'"):
        convert(bag, "-o", tmp_path / "y.csv", "--topics", "/b")


UNDECODABLE = {
    "no definition": Topic(name="/x", type="my/msg/X"),
    "IDL": Topic(
        name="/x", type="my/msg/X", definition=Definition(text="module", encoding="ros2idl")
    ),
    "wide": Topic(name="/x", type="my/msg/X", definition=Definition(text="wstring s\n")),
    "no .msg": Topic(name="/x", type="my/msg/X", definition=Definition(text="what is this\n")),
    "a service": event_topic(f"{LINE}\nSRV: my/srv/X\nmy/Y y\n---\n", "unknown", "my/srv/X"),
    "IDL in a service": event_topic(
        f"{LINE}\nSRV: my/srv/X\nmy/Y y\n---\n{LINE}\nIDL: my/msg/Y\nmodule", "ros2idl", "my/srv/X"
    ),
    "JSON": Topic(name="/x", type="X", serialization="json", definition=Definition(text="{}")),
}


@pytest.mark.parametrize("kind", UNDECODABLE)
def test_a_topic_that_cannot_be_decoded_is_left_out_of_tables(tmp_path: Path, capsys, kind: str):
    topic = UNDECODABLE[kind]
    bag = bag_with(tmp_path / "b", topic, b"\0\1\0\0\4\0\0\0a\0b\0")
    for suffix in ("csv", "jsonl"):
        out, err = printed(capsys, "convert", bag, "-o", tmp_path / f"x.{suffix}")
        assert f"{topic.name}: " in err
        assert "; the topic is left out\n" in err
        assert "Traceback" not in err
        assert "2 messages of 1 topic," in out
        with pytest.raises(BagError):  # nothing is left
            convert(bag, "-o", tmp_path / f"y.{suffix}", "--topics", topic.name)
        assert not (tmp_path / f"y.{suffix}").exists()
    rows = list(csv.DictReader((tmp_path / "x.csv").open()))
    assert [row["data"] for row in rows] == ["text 0", "text 1"]


@pytest.mark.parametrize("kind", UNDECODABLE)
def test_the_other_verbs_do_not_decode_it(tmp_path: Path, capsys, kind: str):
    topic = UNDECODABLE[kind]
    bag = bag_with(tmp_path / "b", topic, b"\0\1\0\0\4\0\0\0a\0b\0")
    out, _ = printed(capsys, "info", "-v", bag)
    number = 2 if "service" in kind else 4  # events of services are counted apart
    assert f"Messages:          {number}\n" in out
    assert printed(capsys, "check", bag)[0] == "b_0.mcap: whole, 4 messages\n"
    convert(bag, "-o", tmp_path / "copy")
    assert list(Bag(str(tmp_path / "copy")).messages()) == list(Bag(str(bag)).messages())
    assert printed(capsys, "compare", bag, tmp_path / "copy")[0].endswith("the bags are alike\n")
    other = bag_with(tmp_path / "c", topic, b"\0\1\0\0\4\0\0\0a\0c\0")
    out, _ = printed(capsys, "compare", bag, other, code=1)
    assert f"{topic.name}: message 0 has other bytes, and " in out
    assert out.endswith("\n1 difference\n")


def test_a_schema_of_bytes_is_copied_as_it_is(tmp_path: Path):
    text = b"\n\x80\xff\0".decode(errors="surrogateescape")
    definition = Definition(text=text, encoding="protobuf")
    topic = Topic(name="/x", type="x.X", serialization="protobuf", definition=definition)
    bag = bag_with(tmp_path / "b", topic, b"x")
    convert(bag, "-o", tmp_path / "copy")
    for folder in (bag, tmp_path / "copy"):
        found = Bag(str(folder)).topic("/x")
        assert found is not None
        assert found.definition == definition


def test_names_of_types_in_two_parts(tmp_path: Path, capsys):
    texts = [("/a", "std_msgs/msg/String", START_NS + n, {"data": f"text {n}"}) for n in range(3)]
    bag = foreign_bag(tmp_path / "b", texts)
    (bag / "metadata.yaml").unlink()
    with sqlite3.connect(next(bag.glob("*.db3"))) as database:
        database.execute("UPDATE topics SET type = 'std_msgs/String', type_description_hash = ''")
        database.execute("DROP TABLE message_definitions")
        database.execute("UPDATE schema SET schema_version = 3")
    database.close()
    out, _ = printed(capsys, "info", bag)
    assert "Topic: /a | Type: std_msgs/msg/String | Count: 3 |" in out
    assert printed(capsys, "check", "--repair", bag)[0].endswith("b.db3: whole, 3 messages\n")
    with Reader(bag) as reader:
        assert len(list(reader.messages())) == 3
    convert(bag, "-o", tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text().count("text ") == 3
    convert(bag, "-o", tmp_path / "copy")
    assert agreed_counts(tmp_path / "copy") == {"/a": 3}
    new = foreign_bag(tmp_path / "new", texts)
    assert printed(capsys, "compare", bag, new)[0].endswith("the bags are alike\n")
    convert(bag, new, "-o", tmp_path / "both")
    assert agreed_counts(tmp_path / "both") == {"/a": 6}
