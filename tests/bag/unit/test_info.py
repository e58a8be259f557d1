"""`bag info`: its text, rates over time, and odd bags."""

from __future__ import annotations

import io
import itertools
import json
import random
import struct
import subprocess
import sys
import tracemalloc
from array import array
from collections import defaultdict
from pathlib import Path
from unittest import mock

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.rosbag2 import StoragePlugin

from launcher.bag import reader, topic_course
from launcher.bag import verbs as bag_verb
from launcher.bag.bag_model import Message, Topic
from launcher.bag.mcap import file as mcap_file
from launcher.bag.reader import Bag
from launcher.bag.topic_course import Course, TopicTimes, measured
from launcher.bag.writer import BagWriter, Storage
from launcher.base.errors import UsageError
from tests.support.bags import (
    START_NS,
    convert,
    counting,
    foreign_bag,
    message,
    string_topic,
    times_of,
    write_bag,
)


@pytest.fixture(autouse=True)
def _a_terminal_of_80_columns(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TZ", "UTC")


def printed(capsys: pytest.CaptureFixture[str], *words: object) -> str:
    assert bag_verb.main(["info", *map(str, words)]) == 0
    return capsys.readouterr().out


def test_the_text_is_that_of_ros2_bag_info(tmp_path: Path, capsys):
    folder = write_bag(tmp_path / "b", [*counting("/b", 20), message("/a", 0.5, "once")])
    size = (folder / "b_0.mcap").stat().st_size / 1024
    assert printed(capsys, folder, "--no-rates").splitlines() == [
        "",
        "Files:             b_0.mcap",
        f"Bag size:          {size:.1f} KiB",
        "Storage id:        mcap",
        "ROS Distro:        jazzy",
        "Duration:          1.900000000s",
        "Start:             Nov 14 2023 22:13:20.000000000 (1700000000.000000000)",
        "End:               Nov 14 2023 22:13:21.900000000 (1700000001.900000000)",
        "Messages:          21",
        "Topic information: Topic: /a | Type: std_msgs/msg/String | Count: 1 | "
        "Serialization Format: cdr",
        "                   Topic: /b | Type: std_msgs/msg/String | Count: 20 | "
        "Serialization Format: cdr",
    ]


def action_bag(folder: Path) -> Path:
    """An action without a topic of its cancellations, a service, and a topic."""
    fold = "fleet/action/Fold"
    topics = {
        "/f/_action/feedback": (f"{fold}_FeedbackMessage", 3),
        "/f/_action/status": ("action_msgs/msg/GoalStatusArray", 2),
        "/f/_action/send_goal/_service_event": (f"{fold}_SendGoal_Event", 4),
        "/f/_action/get_result/_service_event": (f"{fold}_GetResult_Event", 1),
        "/srv/_service_event": ("std_srvs/srv/SetBool_Event", 2),
        "/a": ("std_msgs/msg/String", 5),
    }
    writer = BagWriter(str(folder))
    for name, (type_name, number) in topics.items():
        writer.add_topic(Topic(name=name, type=type_name))
        for one in counting(name, number):
            writer.write(one)
    writer.close()
    return folder


def test_actions_are_counted_apart(tmp_path: Path, capsys):
    bag = action_bag(tmp_path / "b")
    lines = printed(capsys, bag, "--no-rates").splitlines()
    assert lines[8:] == [
        "Messages:          5",
        "Topic information: Topic: /a | Type: std_msgs/msg/String | Count: 5 | "
        "Serialization Format: cdr",
        "Service:           1",
        "Service information: Service: /srv | Type: std_srvs/srv/SetBool | Event Count: 2 | "
        "Serialization Format: cdr",
        "Actions:           1",
        "Action information: ",
        "  Action: /f | Type: fleet/action/Fold | Topics: 2 | Service: 3 | "
        "Serialization Format: cdr",
        "    Topic: feedback | Count: 3",
        "    Topic: status | Count: 2",
        "    Service: send_goal | Event Count: 4",
        "    Service: cancel_goal | Event Count: 0",
        "    Service: get_result | Event Count: 1",
    ]
    assert printed(capsys, bag, "-t") == "/a\n"
    (document,) = json.loads(printed(capsys, bag, "--json"))["bags"]
    assert document["messages"] == 17  # of everything
    (action,) = document["actions"]
    assert (action["name"], action["type"]) == ("/f", "fleet/action/Fold")
    assert [topic["messages"] for topic in action["topics"]] == [3, 1, 4, 2]


def test_sizes_and_calls_of_actions(tmp_path: Path, capsys):
    writer = BagWriter(str(tmp_path / "b"))
    goals, status = "/f/_action/send_goal/_service_event", "/f/_action/status"
    writer.add_topic(Topic(name=goals, type="fleet/action/Fold_SendGoal_Event"))
    writer.add_topic(Topic(name=status, type="action_msgs/msg/GoalStatusArray"))
    writer.write(Message(status, START_NS, START_NS, 0, bytes(10)))
    for number, kind in enumerate((1, 2, 1)):
        writer.write(Message(goals, START_NS, START_NS, 0, service_event(kind, number // 2)))
    writer.close()
    size = 10 + 3 * len(service_event(0, 0))
    lines = printed(capsys, tmp_path / "b", "-v", "--no-rates").splitlines()
    assert lines[-6:] == [
        "  Action: /f | Type: fleet/action/Fold | Topics: 2 | Service: 3 | "
        f"Size Contribution: {size} B | Serialization Format: cdr",
        "    Topic: feedback | Count: 0",
        "    Topic: status | Count: 1",
        "    Service: send_goal | Request Count: 2 | Response Count: 1",
        "    Service: cancel_goal | Request Count: 0 | Response Count: 0",
        "    Service: get_result | Request Count: 0 | Response Count: 0",
    ]
    convert(tmp_path / "b", "-o", tmp_path / "c", "--topics", status)
    assert "Action: /f | Type: unknown | Topics" in printed(capsys, tmp_path / "c")


def test_names_and_order(tmp_path: Path, capsys):
    folder = write_bag(tmp_path / "b", [message("/a", 0, "x"), *counting("/b", 3)])
    assert printed(capsys, folder, "-t") == "/a\n/b\n"
    assert printed(capsys, folder, "-t", "--sort", "count") == "/b\n/a\n"
    with pytest.raises(UsageError, match="'size' is not one of name, type, count"):
        bag_verb.main(["info", str(folder), "--sort", "size"])


def test_rates_show_gaps_and_need_no_decompression(tmp_path: Path, capsys, monkeypatch):
    steady = counting("/steady", 200)
    gappy = [message("/gappy", n / 20, "x") for n in range(400) if not 160 < n < 240]
    ordered = sorted([*steady, *gappy], key=lambda one: one.log_ns)
    folder = write_bag(tmp_path / "b", ordered)
    monkeypatch.setattr(mcap_file.McapFile, "messages", None)
    lines = printed(capsys, folder).splitlines()
    gappy_line = next(line for line in lines if line.startswith("/gappy"))
    steady_line = next(line for line in lines if line.startswith("/steady"))
    assert gappy_line.split()[-4:] == ["20", "16", "20", "4"]
    assert steady_line.split()[-4:] == ["10", "10", "10", "0.1"]
    bar = steady_line[len("/steady  ") :][: -len(" ".join([" " * 7] * 4)) - 2]
    assert set(bar.strip()) == {"█"}
    assert "█   " in gappy_line[9:45]
    assert max(map(len, lines[-3:])) <= 80


def test_bars_are_plain_where_the_terminal_lacks_blocks(tmp_path: Path, monkeypatch):
    folder = write_bag(tmp_path / "b", counting("/a", 50))
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", stream)
    bag_verb.main(["info", str(folder)])
    stream.flush()
    assert b"@@@@" in stream.buffer.getvalue()


@pytest.mark.parametrize("plugin", list(StoragePlugin))
@pytest.mark.parametrize("version", [8, 9])
def test_bags_of_another_library(tmp_path: Path, capsys, plugin, version):
    messages = [("/n", "std_msgs/msg/Int32", START_NS + n * 10**9, {"data": n}) for n in range(11)]
    folder = foreign_bag(tmp_path / "b", messages, plugin=plugin, version=version)
    (document,) = json.loads(printed(capsys, folder, "--json", "-v"))["bags"]
    assert document["messages"] == 11
    assert document["duration_ns"] == 10 * 10**9
    (topic,) = document["topics"]
    assert (topic["name"], topic["type"], topic["messages"]) == ("/n", "std_msgs/msg/Int32", 11)
    assert topic["rate"]["mean_hz"] == 1.0
    assert topic["rate"]["min_hz"] == pytest.approx(1.0)
    assert topic["size_bytes"] == 11 * 8
    assert times_of(Bag(str(folder)))["/n"] == [one[2] for one in messages]


def service_event(kind: int, number: int) -> bytes:
    return struct.pack("<4sB3xiI16s4xq", b"\0\1\0\0", kind, 1, 2, b"client", number)


def test_calls_of_services_are_counted_once(tmp_path: Path, capsys):
    writer = BagWriter(str(tmp_path / "b"))
    name = "/add/_service_event"
    writer.add_topic(Topic(name=name, type="example_interfaces/srv/AddTwoInts_Event"))
    for number in range(3):
        for kind in (0, 1, 2, 3) if number else (0,):
            at_ns = START_NS + number
            writer.write(Message(name, at_ns, at_ns, 0, service_event(kind, number)))
    writer.close()
    text = printed(capsys, tmp_path / "b", "--no-rates")
    assert "Topic information: \n" in text
    assert "Service:           1\n" in text
    assert (
        "Service information: Service: /add | Type: example_interfaces/srv/AddTwoInts | "
        "Event Count: 9 | Serialization Format: cdr\n"
    ) in text
    assert "Request Count: 3 | Response Count: 2 |" in printed(capsys, tmp_path / "b", "-v")
    assert bag_verb.main(["info", str(tmp_path / "b"), "-t"]) == 0
    captured = capsys.readouterr()
    assert captured.out == ""  # as with ros2
    assert captured.err == f"{tmp_path / 'b'}: it has only topics of services and actions\n"


def test_verbose_has_qos_and_sizes(tmp_path: Path, capsys):
    text = printed(capsys, write_bag(tmp_path / "b", counting("/a", 10)), "-v", "--no-rates")
    assert "Count: 10 | Size Contribution: 180 B | Serialization" in text
    assert "QoS: reliable, volatile, history unknown\n" in text


@pytest.mark.parametrize("number", [0, 1, 3])
def test_bags_without_duration(tmp_path: Path, capsys, number: int):
    messages = [message("/a", 0, "x")] * number
    folder = write_bag(tmp_path / "b", messages)
    text = printed(capsys, folder)
    assert f"Messages:          {number}\n" in text
    assert "Duration:          0.000000000s\n" in text
    (document,) = json.loads(printed(capsys, folder, "--json"))["bags"]
    assert [topic["rate"]["mean_hz"] for topic in document["topics"]] == [None] * min(number, 1)


def test_huge_times(tmp_path: Path, capsys):
    writer = BagWriter(str(tmp_path / "b"))
    writer.add_topic(string_topic("/a"))
    for at_ns in (0, 2**62):
        writer.write(Message("/a", at_ns, at_ns, 0, b"\0\1\0\0"))
    writer.close()
    text = printed(capsys, tmp_path / "b")
    assert "Duration:          4611686018.427387904s" in text


def test_an_unfinished_bag_is_told_on_stderr(tmp_path: Path, capsys):
    folder = write_bag(tmp_path / "b", counting("/a", 95))
    storage = folder / "b_0.mcap"
    storage.write_bytes(storage.read_bytes()[:-400])
    (folder / "metadata.yaml").unlink()
    assert bag_verb.main(["info", str(folder)]) == 0
    out, err = capsys.readouterr()
    assert "Messages:          95\n" in out
    assert "it has no metadata.yaml" in err
    assert "bag check --repair" in err


def test_without_indexes_times_come_from_the_messages(tmp_path: Path, monkeypatch):
    folder = write_bag(tmp_path / "b", counting("/a", 30), storage=Storage(max_bytes=2000))
    known = times_of(Bag(str(folder)))
    monkeypatch.setattr(mcap_file, "index_times", lambda block: iter(()))
    assert times_of(Bag(str(folder))) == known
    assert len(known["/a"]) == 30


def test_times_of_files_and_chunks_that_overlap_are_in_order():
    """Chunks by topics, and files of which one begins within the other, as of two recorders."""
    generator = random.Random(1)
    files, expected = [], defaultdict[str, list[int]](list)
    for first in (0, 300):
        starts = sorted(generator.choices(range(first, first + 1000), k=30))
        blocks = []
        for start, following in itertools.zip_longest(starts, starts[1:]):
            times = [start, *(start + generator.randrange(100) for _ in range(20))]
            topic = generator.choice("abc")
            blocks.append((start if following is None else following, {topic: array("q", times)}))
            expected[topic] += times
        files.append((starts[0], iter(blocks)))
    found = defaultdict[str, list[int]](list)
    for topic, times in reader._in_order(files):
        found[topic] += times
    assert found == {topic: sorted(times) for topic, times in expected.items()}


def test_the_times_of_a_long_bag_are_not_kept():
    number, length = 40, 10_000
    blocks = (
        ((n + 1) * length, {"/a": array("q", range(n * length, (n + 1) * length))})
        for n in range(number)
    )
    tracemalloc.start()
    times = measured(reader._in_order([(0, blocks)]), lambda: TopicTimes(0, number * length, 50))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert times["/a"].course().parts_hz == pytest.approx([10**9] * 50, rel=0.01)
    assert times["/a"].count == number * length
    assert peak < 3_000_000  # 8 bytes each would be 3,200,000


@given(st.lists(st.integers(0, 60)), st.integers(1, 10**8))
def test_what_times_show_does_not_depend_on_their_blocks(roots: list[int], length_ns: int):
    times = [*itertools.accumulate((1000 * root**3 for root in roots), initial=10**18)]
    with mock.patch.object(topic_course, "_SAMPLE", 5):
        whole, parts = (TopicTimes(times[0] - 5, times[-1] + 7, 9) for _ in range(2))
        whole.add(times)
        for _, block in itertools.groupby(times, key=lambda time: time // length_ns):
            parts.add(list(block))
        assert parts.course().alone == whole.course().alone
        assert parts.course().parts_hz == pytest.approx(whole.course().parts_hz)
    assert (parts.count, parts.mean_hz) == (whole.count, whole.mean_hz)
    assert parts.longest_gap == whole.longest_gap


def course(times: list[int], end_ns: int, parts: int) -> Course:
    found = TopicTimes(0, end_ns, parts)
    found.add(times)
    return found.course()


def test_a_slow_topic_is_steady_and_a_single_message_counts():
    second = 10**9
    slow = course([0, 4 * second, 8 * second], 10 * second, 20)
    assert slow.parts_hz[:16] == pytest.approx([0.25] * 16)
    assert slow.parts_hz[16:] == (None,) * 4
    single = course([5 * second], 10 * second, 10)
    assert single.parts_hz == (*[None] * 5, 1.0, *[None] * 4)
    assert topic_course.bar(single.parts_hz) == "     █    "
    assert topic_course.bar([1.0, 4.0, 8.0, None]) == "▁▄█ "


def test_a_rate_needs_two_messages(tmp_path: Path, capsys):
    once = message("/once", 4.0, "x")
    folder = write_bag(tmp_path / "b", sorted([*counting("/a", 80), once], key=lambda m: m.log_ns))
    (row,) = [row for row in printed(capsys, folder).splitlines() if row.startswith("/once")]
    assert row.split()[2:] == ["-"] * 4  # behind its name and its bar
    (document,) = json.loads(printed(capsys, folder, "--json"))["bags"]
    rate = next(topic["rate"] for topic in document["topics"] if topic["name"] == "/once")
    assert (rate["min_hz"], rate["mean_hz"], rate["max_hz"]) == (None, None, None)


def test_a_message_alone_behind_a_gap_has_no_rate():
    second = 10**9
    times = [*range(0, 4 * second, second), 90 * second]
    found = course(times, 100 * second, 1000)
    assert (found.least_hz, found.most_hz) == pytest.approx((1.0, 1.0))
    assert found.parts_hz[900] is not None  # it is in the bar
    wide = course([0, 1, 2, 9 * second, 9 * second + 50], 10 * second, 2)
    assert wide.least_hz is not None


@pytest.mark.parametrize(
    "words", [["info", "B"], ["convert", "B", "-o", "C.csv"], ["compare", "B", "B"]]
)
def test_looking_at_bags_needs_no_ros(tmp_path: Path, words: list[str]):
    write_bag(tmp_path / "B", counting("/a", 5))
    code = (
        "import sys\n"
        "from launcher.bag import verbs\n"
        "verbs.main(sys.argv[1:])\n"
        "sys.exit(any(name.startswith('rclpy') for name in sys.modules))\n"
    )
    subprocess.run([sys.executable, "-c", code, *words], cwd=tmp_path, check=True)
