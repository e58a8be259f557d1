"""Exit codes of `tf`, and mistakes in its command lines."""

from __future__ import annotations

import json
from collections.abc import Callable

import pytest

from launcher.base.command_line import Parsed
from launcher.ros.tf.arithmetic import Transform
from launcher.ros.tf.frame_buffer import StampedTransform
from launcher.ros.tf.frame_tree import TfSample
from launcher.ros.topics.clock import WallClock
from launcher.ros.verbs import tf
from tests.support.verbs import in_process

S = 1_000_000_000


def sample(parent: str, child: str) -> TfSample:
    return TfSample(5 * S, False, "", [StampedTransform(parent, child, 5 * S, Transform())])


@pytest.fixture
def bag(monkeypatch: pytest.MonkeyPatch) -> list[TfSample]:
    samples = [sample("map", "odom")]
    monkeypatch.setattr(tf, "_of_bag", lambda options: iter(samples))
    return samples


def test_a_tree_with_problems_is_not_done(bag: list[TfSample]):
    assert in_process("tf", "tree", "robot.bag").code == 0

    bag.append(sample("space", "moon"))

    assert in_process("tf", "tree", "robot.bag").code == 1
    answer = in_process("tf", "tree", "robot.bag", "--json")
    assert (answer.code, len(json.loads(answer.out)["problems"])) == (1, 1)
    assert (
        in_process("tf", "tree", "robot.bag", "--dot").code == 0
    )  # a drawing says nothing of them


@pytest.mark.parametrize("verb", ["echo", "monitor"])
@pytest.mark.parametrize(
    ("frames", "error"),
    [
        (
            ["/map", "cam"],
            "error: '/map': in tf2 the name of a frame cannot begin with a slash\n"
            "hint: did you mean map?\n",
        ),
        (["cam", ""], "error: the name of a frame is empty\nhint: is a shell variable unset?\n"),
    ],
)
def test_names_that_no_frame_can_have(verb: str, frames: list[str], error: str):
    answer = in_process("tf", verb, *frames)

    assert (answer.code, answer.out, answer.err) == (2, "", error)


@pytest.mark.parametrize("words", ["tree -t 2", "monitor --for 2"])
def test_without_a_clock_nothing_has_an_age(monkeypatch: pytest.MonkeyPatch, words: str):
    def received(options: Parsed, clock: WallClock, tick: Callable[[], bool]):
        tick()
        yield sample("map", "odom")

    monkeypatch.setattr(tf, "_received", received)

    answer = in_process("tf", *words.split(), "--use-sim-time")

    assert (answer.code, answer.out, answer.err) == (1, "", "no time on /clock within 2 s\n")


def test_what_comes_before_the_first_time_on_the_clock_is_kept(monkeypatch: pytest.MonkeyPatch):
    def received(options: Parsed, clock: WallClock, tick: Callable[[], bool]):
        yield sample("map", "odom")
        monkeypatch.setattr(clock, "now_ns", lambda: 6 * S)
        tick()

    monkeypatch.setattr(tf, "_received", received)

    answer = in_process("tf", "monitor", "map", "odom", "--for", "2", "-s", "--json")

    assert (answer.code, json.loads(answer.out)["chain"]) == (0, ["map", "odom"])
