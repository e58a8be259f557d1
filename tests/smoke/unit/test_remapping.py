"""Rules that put a topic of a node under another name."""

from __future__ import annotations

import pytest

from launcher.base.model.spec import ProcessSpec, RosIdentity
from launcher.ros.helpers.topic_proxy import MessageFilter
from launcher.smoke.inject.remapping import refusal, renamed


def node(*words: str) -> ProcessSpec:
    return ProcessSpec("a-1", "a", ("a", *words), {}, ros=RosIdentity(namespace="/"))


@pytest.mark.parametrize(
    ("words", "rules"),
    [
        ("", "/scan:=X"),
        ("--ros-args -r __node:=n -p x:=1", "/scan:=X"),
        ("--ros-args -r scan:=/scan", "scan:=X"),
        ("--ros-args -r __node:=n -r lidar:=scan", "lidar:=X /scan:=X"),
        ("--ros-args -r __node:=n -r n:lidar:=scan", "n:lidar:=X /scan:=X"),
        ("--ros-args -r lidar:=ns/scan", "/scan:=X"),
        ("--ros-args -r a:=/scan -r /scan:=/other", "a:=X"),  # the node's own goes elsewhere
    ],
)
def test_rules_come_in_front_of_those_that_lead_to_the_topic(words: str, rules: str):
    before = node(*words.split())
    after = renamed(before, "/scan")
    new = [word for rule in rules.replace("X", "/scan/_injected").split() for word in ("-r", rule)]
    assert after.argv == ("a", "--ros-args", *new, *before.argv[1:])


def test_what_is_no_single_node_is_refused():
    spec = node()
    assert refusal(spec) == ""
    assert "several nodes" in refusal(ProcessSpec("a-1", "a", ("a",), {}, members=(spec,)))
    assert "shell" in refusal(ProcessSpec("a-1", "a", ("a",), {}, shell=True))
    assert "not started as a ROS node" in refusal(ProcessSpec("a-1", "a", ("a",), {}))


@pytest.mark.parametrize(
    ("percent", "passed"), [(100, []), (50, [0, 2, 4, 6]), (25, [0, 1, 2, 4, 5, 6])]
)
def test_messages_are_dropped_evenly(percent: float, passed: list[int]):
    messages = MessageFilter({"percent": percent})
    for number in range(8):
        messages.add(bytes([number]), 0.0)
    assert [one[0] for one in messages.due(0.0)] == passed


def test_messages_are_late_in_order():
    messages = MessageFilter({"delay_s": 0.5})
    messages.add(b"a", 1.0)
    messages.add(b"b", 1.2)
    assert (messages.due(1.49), messages.wait_s(1.48)) == ([], pytest.approx(0.02))
    assert (messages.due(1.5), messages.due(2.0)) == ([b"a"], [b"b"])
