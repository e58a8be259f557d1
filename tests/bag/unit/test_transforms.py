"""`tf tree` and `tf echo` of bags, without ROS and without the type of the messages."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from launcher.bag.bag_model import Message, Topic
from launcher.bag.writer import BagWriter
from tests.support.bags import QOS, START_NS, write_bag
from tests.support.bags import message as string_message
from tests.support.json_forms import fit
from tests.support.tf_messages import tf_message
from tests.support.verbs import in_process

TYPE = "tf2_msgs/msg/TFMessage"
LEFT = (0.0, 0.0, math.sin(math.pi / 4), math.cos(math.pi / 4))
STRAIGHT = (0.0, 0.0, 0.0, 1.0)


def moving(at_s: float) -> Message:
    """The robot drives 1 m/s along x."""
    stamp_ns = START_NS + round(at_s * 1e9)
    data = tf_message(("map", "base", stamp_ns, (at_s, 0.0, 0.0), STRAIGHT))
    return Message("/tf", stamp_ns + 1_000_000, stamp_ns, 0, data)


def transform_bag(folder: Path, *more: Message, moving_topic: str = "/tf") -> str:
    static = tf_message(("base", "laser", 0, (0.5, 0.0, 0.0), LEFT))
    messages = [
        Message("/tf_static", START_NS, START_NS, 0, static),
        *(moving(number / 10)._replace(topic=moving_topic) for number in range(31)),
        *more,
    ]
    writer = BagWriter(str(folder), None, ros_distro="jazzy")
    for name in dict.fromkeys(message.topic for message in messages):
        writer.add_topic(Topic(name=name, type=TYPE, qos=[QOS]))
    for message in messages:
        writer.write(message)
    writer.close()
    return str(folder)


def test_the_tree_of_a_bag(tmp_path):
    answer = in_process("tf", "tree", transform_bag(tmp_path / "bag"))

    assert answer.lines == [
        "map",
        "└─ base      10.0 Hz, buffer 3.00 s, newest 0.00 s, oldest 3.00 s old",
        "   └─ laser  static",
    ]
    assert (answer.code, answer.err) == (0, "")


def test_the_form_of_a_tree(tmp_path):
    [document] = fit(
        "tf tree", in_process("tf", "tree", transform_bag(tmp_path / "b"), "--json").out
    )

    assert [one["frame"] for one in document["frames"]] == ["base", "laser"]


def test_the_transform_is_shown_as_it_was_while_the_bag_was_recorded(tmp_path):
    bag = transform_bag(tmp_path / "bag")

    answer = in_process("tf", "echo", "map", "laser", "--bag", bag, "--json")

    found = fit("tf echo", answer.out)
    assert [round(one["translation"][0], 6) for one in found] == [0.5, 1.5, 2.5]
    assert found[0]["rotation"] == pytest.approx(LEFT)


def test_a_transform_at_one_time_is_interpolated(tmp_path):
    bag = transform_bag(tmp_path / "bag")

    answer = in_process("tf", "echo", "map", "base", "--bag", bag, "-t", f"{START_NS // 10**9}.25")

    assert answer.lines[:2] == [
        f"At time {START_NS // 10**9}.250000000",
        "- Translation: [0.250, 0.000, 0.000]",
    ]


def test_a_transform_that_a_bag_does_not_have(tmp_path):
    bag = transform_bag(tmp_path / "bag")

    answer = in_process("tf", "echo", "map", "nose", "--bag", bag)

    assert (answer.code, answer.out) == (1, "")
    assert answer.err == (
        'no transform map -> nose: Invalid frame ID "nose" passed to canTransform argument '
        "source_frame - frame does not exist\n"
    )


def test_once_is_the_first_transform(tmp_path):
    bag = transform_bag(tmp_path / "bag")

    answer = in_process("tf", "echo", "map", "base", "--bag", bag, "--once")

    assert answer.lines[0] == f"At time {START_NS // 10**9}.000000000"
    assert sum(line.startswith("At") for line in answer.lines) == 1


def test_topics_with_other_names(tmp_path):
    bag = transform_bag(tmp_path / "bag", moving_topic="/bot1/tf")

    answer = in_process("tf", "tree", bag, "--tf-topic", "bot1/tf", "--json")

    assert json.loads(answer.out)["roots"] == ["map"]
    missing = in_process("tf", "tree", bag, "--tf_topic", "/x", "--tf_static_topic", "/y")
    assert missing.code == 1
    assert missing.err == (
        f"error: {bag}: no transforms on /x and /y\n"
        "hint: --tf-topic and --tf-static-topic: it has /bot1/tf, /tf_static\n"
    )


def test_a_bag_without_transforms(tmp_path):
    bag = write_bag(tmp_path / "bag", [string_message("/chatter", 0.0, "x")])

    answer = in_process("tf", "tree", str(bag))

    assert (answer.code, answer.err) == (1, f"error: {bag}: no transforms on /tf and /tf_static\n")


def test_a_damaged_message_is_named(tmp_path):
    bag = transform_bag(tmp_path / "bag", moving(4.0)._replace(data=b"\0\1\0\0\1\0\0\0x"))

    answer = in_process("tf", "tree", bag)

    assert answer.code == 1
    assert answer.err.startswith(f"error: {bag}: /tf: a message is not a {TYPE}: ")


def test_drawings_are_written(tmp_path):
    bag, name = transform_bag(tmp_path / "bag"), str(tmp_path / "frames")

    answer = in_process("tf", "tree", bag, "-o", name)

    assert answer.err == f"wrote {name}.gv\nwrote {name}.svg\n"
    assert (
        '"map" -> "base"[label=" Broadcaster: default_authority' in Path(f"{name}.gv").read_text()
    )
    assert "<svg" in Path(f"{name}.svg").read_text(encoding="utf-8")
    assert in_process("tf", "tree", bag, "--dot").out == Path(f"{name}.gv").read_text()
