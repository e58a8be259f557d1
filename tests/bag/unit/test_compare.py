"""`bag compare`: what differs, what is tolerated, and how it is told."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from launcher.bag import metadata
from launcher.bag import verbs as bag_verb
from launcher.bag.bag_model import BagError, Definition, Message, Topic
from launcher.bag.writer import BagWriter
from launcher.base.errors import UsageError
from tests.support.bags import (
    START_NS,
    counting,
    foreign_bag,
    message,
    string_topic,
    write_bag,
)


def compare(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[int, str]:
    code = bag_verb.main(["compare", *map(str, words)])
    return code, capsys.readouterr().out


def differences(capsys: pytest.CaptureFixture[str], *words: object) -> list[tuple[str, str]]:
    """(topic, kind) of each."""
    code, out = compare(capsys, *words, "--json")
    document = json.loads(out)
    assert document["alike"] is (code == 0)
    return [
        (topic["name"], one["kind"]) for topic in document["topics"] for one in topic["differences"]
    ]


@pytest.fixture
def good(tmp_path: Path) -> Path:
    return write_bag(tmp_path / "good", counting("/a", 50))


def test_a_bag_is_like_itself(good: Path, capsys):
    code, out = compare(capsys, good, good)
    assert code == 0
    assert out.splitlines() == [
        f"A: {good}: 50 messages in 4.900 s",
        f"B: {good}: 50 messages in 4.900 s",
        "",
        "topic  messages  rate (Hz)  longest gap (s)  latency (ms)  99 % (ms)",
        "/a     50        10         0.1              1             1",
        "",
        "the bags are alike",
    ]


def test_a_later_recording_of_the_same_is_alike(good: Path, tmp_path: Path, capsys):
    later = [one._replace(log_ns=one.log_ns + 5 * 10**9) for one in counting("/a", 50)]
    code, out = compare(capsys, good, write_bag(tmp_path / "b", later))
    assert "B begins 5.000 s later than A; the times count from each start" in out
    assert "1 / 5e+03" in out  # the latency
    assert code == 0


def test_topics_numbers_rates_and_gaps(good: Path, tmp_path: Path, capsys):
    other = [message("/a", n * 0.2, f"message {n}") for n in range(40) if not 10 <= n < 20]
    b = write_bag(tmp_path / "b", [*other, message("/new", 9, "x")])
    code, out = compare(capsys, good, b, "--gap-tolerance", "50%")
    assert code == 1
    assert out.splitlines()[-7:] == [
        "",
        "/a: 50 messages in A, 30 in B",
        "/a: 10 Hz in A, 3.72 Hz in B",
        "/a: the longest gap is 0.1 s in A, 2.2 s in B",
        "/a: message 10: data is 'message 10' in A, 'message 20' in B",
        "/new: only in B (std_msgs/msg/String)",
        "5 differences",
    ]
    assert differences(capsys, b, good, "--no-fields") == [
        ("/a", "count"),
        ("/a", "rate"),
        ("/new", "missing"),
    ]
    tolerant = ["--count-tolerance", "20", "--rate-tolerance", "0.7", "--exclude-topics", "new"]
    assert differences(capsys, good, b, "--no-fields", *tolerant) == []
    tolerant[1] = "40%"
    assert differences(capsys, good, b, "--no-fields", *tolerant) == []


def test_few_messages_have_no_rate_that_is_judged(tmp_path: Path, capsys):
    a = write_bag(tmp_path / "a", [message("/a", t, "x") for t in (0, 1, 2)])
    b = write_bag(tmp_path / "b", [message("/a", t, "x") for t in (0, 5, 9)])
    assert differences(capsys, a, b) == []


def test_only_the_common_time_counts_without_alignment(good: Path, tmp_path: Path, capsys):
    cut = tmp_path / "cut"
    bag_verb.main(["convert", str(good), "-o", str(cut), "--start", "2", "--duration", "1"])
    capsys.readouterr()
    assert differences(capsys, good, cut, "--align", "none") == []
    code, out = compare(capsys, cut, good, "--align", "none")
    assert "B begins 2.000 s earlier than A; the time of both counts" in out
    assert code == 0
    assert ("/a", "field") in differences(capsys, good, cut)


def test_without_common_time(good: Path, tmp_path: Path, capsys):
    later = [one._replace(log_ns=one.log_ns + 10**12) for one in counting("/a", 5)]
    with pytest.raises(BagError, match="have no time in common"):
        compare(capsys, good, write_bag(tmp_path / "b", later), "--align", "none")


def typed(folder: Path, topic: Topic, datas: list[bytes]) -> Path:
    writer = BagWriter(str(folder))
    writer.add_topic(topic)
    for number, data in enumerate(datas):
        writer.write(Message(topic.name, START_NS + number, START_NS + number, 0, data))
    writer.close()
    return folder


def test_types_and_hashes(good: Path, tmp_path: Path, capsys):
    other = typed(tmp_path / "b", Topic(name="/a", type="x/msg/X"), [b""] * 50)
    assert ("/a", "type") in differences(capsys, good, other)
    hashed = replace(string_topic("/a"), type_hash="RIHS01_0")
    writer = BagWriter(str(tmp_path / "c"))
    writer.add_topic(hashed)
    for one in counting("/a", 50):
        writer.write(one)
    writer.close()
    assert differences(capsys, good, tmp_path / "c") == [("/a", "hash")]


def numbers_bag(folder: Path, change: Callable[[dict[str, object]], object] | None = None) -> Path:
    def point(x: float) -> dict[str, object]:
        return {"geometry_msgs/msg/Point": {"x": x, "y": float("nan"), "z": 0.0}}

    def pose(x: float) -> dict[str, object]:
        turn = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
        fields = {"position": point(x), "orientation": {"geometry_msgs/msg/Quaternion": turn}}
        return {"geometry_msgs/msg/Pose": fields}

    values = {"sec": 1, "frame": "map", "x": [1.0, 2.0, 1000.0]}
    messages: list[tuple[str, str, int, object]] = []
    for number in range(5):
        if number == 3 and change is not None:
            change(values)
        stamp = {"builtin_interfaces/msg/Time": {"sec": values["sec"], "nanosec": 0}}
        header = {"std_msgs/msg/Header": {"stamp": stamp, "frame_id": values["frame"]}}
        fields = {"header": header, "poses": [pose(x) for x in values["x"]]}
        messages.append(("/p", "geometry_msgs/msg/PoseArray", START_NS + number * 10**9, fields))
    return foreign_bag(folder, messages)


@pytest.mark.parametrize(
    ("change", "told", "tolerated"),
    [
        ({"sec": 2}, "header.stamp.sec is 1 in A, 2 in B", ["--ignore-stamps"]),
        ({"sec": 2}, "header.stamp.sec is 1 in A", ["--ignore-field", "header.stamp"]),
        ({"frame": "odom"}, "frame_id is 'map' in A, 'odom' in B", ["--ignore-field", "header"]),
        ({"x": [1.0, 2.5, 1000.0]}, "poses[1].position.x is 2.0", ["--tolerance", "0.5"]),
        ({"x": [1.0, 2.0, 1001.0]}, "poses[2].position.x is", ["--relative-tolerance", "0.1%"]),
        ({"x": [1.0, 2.0, 9.0]}, "poses[2].position.x", ["--ignore-field", "poses.position.x"]),
        ({"x": [1.0, 2.0, 9.0]}, "poses[2].position.x", ["--ignore-field", "poses[2]"]),
        ({"x": [1.0]}, "the length of poses is 3 in A, 1 in B", ["--ignore-field", "poses"]),
    ],
)
def test_fields(tmp_path: Path, capsys, change, told: str, tolerated: list[str]):
    a = numbers_bag(tmp_path / "a")
    b = numbers_bag(tmp_path / "b", lambda values: values.update(change))
    code, out = compare(capsys, a, b)
    assert code == 1
    assert "/p: message 3: " in out
    assert told in out
    assert compare(capsys, a, b, *tolerated)[0] == 0
    assert compare(capsys, a, b, "--no-fields")[0] == 0


@pytest.mark.parametrize(
    "words", [["--ignore-field", "poses[1]"], ["--tolerance", "0.9"], ["--ignore-stamps"]]
)
def test_what_is_tolerated_elsewhere_does_not_count(tmp_path: Path, capsys, words):
    a = numbers_bag(tmp_path / "a")
    b = numbers_bag(tmp_path / "b", lambda values: values.update(x=[1.0, 2.0, 1001.0]))
    assert differences(capsys, a, b, *words) == [("/p", "field")]


def test_without_definitions_bytes_are_compared(tmp_path: Path, capsys):
    topic = Topic(name="/a", type="x/msg/X")
    a = typed(tmp_path / "a", topic, [b"1", b"2"])
    b = typed(tmp_path / "b", topic, [b"1", b"3"])
    assert differences(capsys, a, a) == []
    _, out = compare(capsys, a, b)
    assert "/a: message 1 has other bytes, and the bag has no definition of x/msg/X" in out


def test_definitions_of_one_bag_are_enough(tmp_path: Path, capsys):
    text = Definition(text="uint8 n\n")
    topic = Topic(name="/a", type="x/msg/X")
    a = typed(tmp_path / "a", topic, [b"\0\1\0\0\1"])
    b = typed(tmp_path / "b", replace(topic, definition=text), [b"\0\1\0\0\2"])
    assert "message 0: n is 1 in A, 2 in B" in compare(capsys, a, b)[1]


def test_padding_of_equal_messages_does_not_count(tmp_path: Path, capsys):
    topic = Topic(name="/a", type="x/msg/X", definition=Definition(text="uint8 n\nuint16 m\n"))
    a = typed(tmp_path / "a", topic, [b"\0\1\0\0\1\0\3\0"])
    b = typed(tmp_path / "b", topic, [b"\0\1\0\0\1\xff\3\0"])
    assert differences(capsys, a, b) == []


def test_empty_and_unfinished_bags(good: Path, tmp_path: Path, capsys):
    empty = write_bag(tmp_path / "empty", [])
    assert differences(capsys, empty, empty) == []
    assert differences(capsys, good, empty) == [("/a", "missing")]
    cut = tmp_path / "cut"
    shutil.copytree(good, cut)
    (cut / metadata.FILE).unlink()
    storage = cut / "good_0.mcap"
    storage.write_bytes(storage.read_bytes()[:1500])
    assert bag_verb.main(["compare", str(good), str(cut)]) == 1
    out, err = capsys.readouterr()
    assert "messages in A" in out
    assert "bag check --repair" in err


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["one"], "is missing"),
        (["one", "two", "three"], "unexpected argument 'three'"),
        (["one", "two", "--align", "end"], "'end' is not one of start, none"),
        (["one", "two", "--tolerance", "x"], "--tolerance: 'x' is not a number"),
        (["one", "two", "--tolerance=-1"], "'-1' is not a number of at least 0"),
        (["one", "two", "--rate-tolerance", "ten%"], "--rate-tolerance: 'ten' is not a number"),
        (["one", "two", "--count-tolerance", "nan"], "'nan' is not a number of at least 0"),
        (["one", "two", "--relative-tolerance", "inf"], "'inf' is not a number"),
    ],
)
def test_mistakes_of_the_command_line(words: list[str], text: str):
    with pytest.raises(UsageError, match=text):
        bag_verb.main(["compare", *words])
