"""`bag play`: the options that ROS 2 has for the order of messages, its inputs and its end."""

from __future__ import annotations

import re
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from launcher.bag.bag_model import Topic
from launcher.bag.writer import BagWriter
from tests.bag.ros.test_play import PADDED, STRING, heard, listening, playing
from tests.support.bags import START_NS, counting, string_topic, write_bag
from tests.support.node_process import line_of
from tests.support.ros_domain import ros_domain
from tests.support.verbs import launcher
from tests.support.waiting import rest_of


@pytest.fixture
def domain(tmp_path: Path) -> Iterator[dict[str, str]]:
    with ros_domain(tmp_path / "log") as env:
        yield env


@pytest.mark.thorough
def test_bags_behind_i_are_played_together_as_well(domain, tmp_path: Path):
    first = write_bag(tmp_path / "first", counting("/chatter", 20, 0.01)[::2])
    second = write_bag(tmp_path / "second", counting("/chatter", 20, 0.01)[1::2])
    with listening(domain, f"/chatter={STRING}") as listener:
        words = ("-i", str(first), "mcap", "-i", str(second))
        answer = launcher(domain, "bag", "play", *words, "--progress-bar-update-rate", "-1")
        assert answer.code == 0, answer
        assert [bytes.fromhex(one[1]) for one in heard(listener, 20)] == PADDED[:20]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ([], [0, 1, 2, 3, 4]),
        (["--message-order", "received"], [0, 1, 2, 3, 4]),
        (["--message-order", "sent"], [1, 0, 2, 4, 3]),
        (["--message-order", "sent", "--read-ahead-queue-size", "1"], [1, 0, 2, 4, 3]),
        (["--message-order", "sent", "--start-offset", "0.25"], [4, 3]),
        (["--message-order", "sent", "--playback-duration", "0.25"], [1, 0, 2]),
        (["--message-order", "sent", "--playback-until-nsec", str(START_NS - 10**9)], [1]),
    ],
    ids=lambda value: " ".join(map(str, value)),
)
def test_the_order_of_messages(domain, tmp_path: Path, words: list[str], expected: list[int]):
    sent = [-0.9, -1.0, -0.8, -0.6, -0.7]  # all before the first one was received
    messages = [
        one._replace(publish_ns=START_NS + round(at_s * 1e9))
        for one, at_s in zip(counting("/chatter", 5), sent, strict=True)
    ]
    bag = write_bag(tmp_path / "bag", messages)
    with listening(domain, f"/chatter={STRING}") as listener:
        answer = launcher(domain, "bag", "play", str(bag), *words)
        assert answer.code == 0, answer
        assert answer.err.endswith(
            f"played {len(expected)} messages\n".replace("1 messages", "1 message")
        )
        found = [bytes.fromhex(data) for _, data, _ in heard(listener, len(expected))]
    assert found == [PADDED[n] for n in expected]


@pytest.mark.thorough
def test_the_offset_is_within_the_times_of_the_order(domain, tmp_path: Path):
    messages = [
        one._replace(publish_ns=START_NS + n * 10**9)  # they take longer than those of receiving
        for n, one in enumerate(counting("/chatter", 4))
    ]
    words = ("bag", "play", str(write_bag(tmp_path / "bag", messages)), "--message-order", "sent")
    answer = launcher(domain, *words, "--start-offset", "2.5")
    assert (answer.code, answer.err) == (0, "playing 1 topic\nplayed 1 message\n")
    answer = launcher(domain, *words, "--start-offset", "3.5")
    assert answer.code == 2
    assert answer.err.startswith("error: --start-offset is behind the end: the bag has 3.000 s")


@pytest.mark.thorough
def test_a_clock_in_the_bag_gives_way_to_the_clock_of_the_player(domain, tmp_path: Path):
    writer = BagWriter(str(tmp_path / "bag"))
    writer.add_topic(Topic(name="/clock", type="rosgraph_msgs/msg/Clock"))
    writer.add_topic(string_topic("/chatter"))
    for one in counting("/chatter", 10):
        writer.write(one)
    writer.close()
    words = ("bag", "play", str(tmp_path / "bag"))
    assert launcher(domain, *words, "--clock").err.startswith("playing 1 topic\n")
    assert launcher(domain, *words).err.startswith("playing 2 topics\n")


@pytest.mark.thorough
def test_sigterm_ends_it_as_ctrl_c_does(domain, tmp_path: Path):
    bag = str(write_bag(tmp_path / "bag", counting("/chatter", 1000, 0.1)))
    with playing(domain, bag) as player:
        assert line_of(player.stderr) == "playing 1 topic\n"
        player.send_signal(signal.SIGTERM)
        assert re.fullmatch(r"played \d+ messages?\n", rest_of(player)[1])
        assert player.returncode == 0


def test_bags_are_arguments_or_inputs(domain, tmp_path: Path):
    answer = launcher(domain, "bag", "play", "--rate", "2")
    assert (answer.code, answer.err.splitlines()[0]) == (2, "error: no bag to play was named")
    answer = launcher(domain, "bag", "play", "a", "-i", "b")
    assert (answer.code, answer.err) == (
        2,
        "error: bags are arguments, or each follows -i; not both\nhint: -i a -i b\n",
    )
