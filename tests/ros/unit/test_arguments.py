"""Impossible option values of the ROS verbs, and names of types."""

from __future__ import annotations

import pytest

from launcher.ros.messages.interfaces import full_type, near_miss
from tests.support.verbs import in_process

TOO_MANY = "99999999999999999999"


@pytest.mark.parametrize(
    "words",
    [
        *(
            [verb, *arguments, option]
            for verb, *arguments in (
                ["echo", "/t"],
                ["hz", "/t"],
                ["bw", "/t"],
                ["delay", "/t"],
                ["pub", "/t", "std_msgs/msg/String"],
            )
            for option in ("--qos-depth=-1", "--qos-liveliness-lease-duration-seconds=nan")
        ),
        ["echo", "/t", "--qos-depth", "0"],
        ["echo", "/t", "--qos-depth", "3000000000"],
        ["echo", "/t", "--qos-depth", "few"],
        ["echo", "/t", "--qos-liveliness-lease-duration-seconds", "1e10"],
        ["echo", "/t", "--truncate-length", "²"],
        ["hz", "/t", "--window", TOO_MANY],
        ["hz", "/t", "--for", "1", "--min", "nan"],
        ["pub", "/t", "std_msgs/msg/String", "--times", TOO_MANY],
        ["pub", "/t", "std_msgs/msg/String", "--rate", "nan"],
        ["pub", "/t", "std_msgs/msg/String", "--rate", "1e-320"],
    ],
    ids=" ".join,
)
def test_an_impossible_number_is_a_usage_error(words):
    answer = in_process("topic", *words)
    assert (answer.out, answer.code) == ("", 2)
    assert answer.err.startswith("error: ")
    assert len(answer.err.splitlines()) <= 2


@pytest.mark.parametrize(
    ("word", "near"),
    [
        ("std_msgs/msg/Nope", None),
        ("std_msgs", None),
        ("/", None),
        ("KeyValue", None),  # of several packages
        ("std_msgs/Strnig", "std_msgs/msg/String"),
        ("std_msgs/msg/string", "std_msgs/msg/String"),
        ("geometry_msg/Twist", "geometry_msgs/msg/Twist"),
        ("std_srvs/SetBol", "std_srvs/srv/SetBool"),
    ],
)
def test_only_a_type_with_a_similar_name_is_suggested(word, near):
    assert near_miss(word) == near


@pytest.mark.parametrize(
    ("word", "full"),
    [
        ("std_msgs/String", "std_msgs/msg/String"),
        ("std_msgs/msg/String", "std_msgs/msg/String"),
        ("String", "String"),
        ("a/action/Fold_FeedbackMessage", "a/action/Fold_FeedbackMessage"),
    ],
)
def test_the_short_form_of_a_type(word, full):
    assert full_type(word) == full
