"""Exit codes of the ROS verbs: the table in docs/reference/ros-verbs.md, and those of ros2cli."""

from __future__ import annotations

import re
import shlex

import pytest

from tests.support.repository import docs_page

PAGE = docs_page("ros-verbs")
# Those with a placeholder need more than the sample nodes.
ROWS = re.findall(r"^\| `([^`A-Z]*[^`]*)` \| (\d) \| (\d) \|", PAGE, re.MULTILINE)
DIFFERENT = [(line, int(here)) for line, here, _ in ROWS if not re.search(r"\b[A-Z]{4,}\b", line)]
AS_ROS2 = [
    ("topic lsit", 2),
    ("topic list --bogus", 2),
    ("topic info", 2),
    ("topic info /nope", 1),
    ("topic type /nope", 1),
    ("topic find std_msgs/msg/Empty", 0),
    ("topic pub /x std_msgs/msg/String -r 0", 2),
    ("topic pub /x std_msgs/msg/Nope --once", 1),
    ("topic pub /x std_msgs/msg/String 'nope: 1' --once -w 0", 1),
    ("topic pub /x std_msgs/msg/String --once --max-wait-time-secs 0.1", 1),
    ("node info /nope", 1),
    ("service type /nope", 1),
    ("service info /nope", 1),
    ("service call /switch std_srvs/srv/Nope", 1),
    ("service call /switch std_srvs/srv/SetBool 'nope: 1'", 1),
    ("action info /nope", 0),
    ("action type /nope", 1),
    ("action send_goal /nope std_srvs/action/Nope", 1),
    ("lifecycle get /nope", 1),
    ("lifecycle list /nope", 1),
    ("lifecycle set /nope configure", 1),
    ("param get /nope speed", 1),
    ("param get /talker nope", 1),
    ("param get /talker speed nope", 1),
    ("param get nope", 0),
    ("service call /switch std_srvs/srv/SetBool '{}' --stdin", 2),
    ("param load /talker /nope.yaml", 1),
    ("interface package nope", 1),
    ("interface show std_msgs/msg/Nope", 1),
    ("interface proto std_msgs/msg/Nope", 1),
    ("pkg prefix nope", 1),
    ("pkg executables nope", 1),
    ("pkg xml nope", 1),
    ("daemon status", 0),
]


def test_the_table_has_rows_to_run():
    assert len(DIFFERENT) > 8


@pytest.mark.parametrize(("line", "code"), DIFFERENT)
def test_a_code_that_ros2_does_not_have_is_the_documented_one(verb, line: str, code: int):
    answer = verb(*shlex.split(line))
    assert answer.code == code, answer


@pytest.mark.thorough
@pytest.mark.parametrize(("line", "code"), AS_ROS2)
def test_other_codes_are_those_of_ros2(verb, line: str, code: int):
    answer = verb(*shlex.split(line))
    assert answer.code == code, answer
