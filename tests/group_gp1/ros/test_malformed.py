"""Payloads that cannot be used: counted, warned about now and then, dropped."""

from __future__ import annotations

import json
import re
import time

import pytest

from group_gp1 import qos, topics
from group_gp1.logic.messages import RobotStatus, Status, TaskAssignment

GOOD_TASK = TaskAssignment(robot_id="robot_1", task="pick_shelf_A3", task_id="t-1").to_json()
GOOD_STATUS = RobotStatus(
    robot_id="robot_1", status=Status.DONE, task="pick_shelf_A3", task_id="t-1"
).to_json()
BAD = (
    "",
    "not json",
    "null",
    "[]",
    "42",
    '"text"',
    "{",
    "[" * 3000,
    "x" * 20_000,
    "{}",
    json.dumps({"robot_id": "robot_1"}),
    json.dumps({"robot_id": None, "task": "a", "status": "done"}),
    json.dumps({"robot_id": "robot_1", "task": 7, "status": "done"}),
    json.dumps({"robot_id": "robot_1", "task": ["a"], "status": "done"}),
    json.dumps({"robot_id": "robot_1", "task": {"a": 1}, "status": "done"}),
    json.dumps({"robot_id": "robot_1", "task": "", "status": "busy"}),
    json.dumps({"robot_id": "robot_1", "task": "a\n[INFO] forged", "status": "done"}),
    json.dumps({"robot_id": "robot_1", "task": "a" * 500, "status": "done"}),
    json.dumps({"robot_id": "robot_1", "task": "a", "status": "done", "task_id": 5}),
)
TIMEOUT_S = 120.0
COUNT = r"Dropped a malformed payload on (\S+) \((\d+) so far\): (.+)"
CASES = [
    ("robot_1", topics.TASKS, qos.TASKS, GOOD_TASK, "Task pick_shelf_A3 complete"),
    pytest.param(
        *("monitor", topics.STATUS, qos.STATUS, GOOD_STATUS, "Fleet report -- robot_1: 1 tasks"),
        marks=pytest.mark.thorough,
    ),
]


@pytest.mark.parametrize(
    ("name", "topic", "profile", "good", "sign_of_life"), CASES, ids=["robot_1", "monitor"]
)
def test_a_node_counts_and_drops_what_it_cannot_use(
    domain, name, topic, profile, good, sign_of_life
):
    node = domain.start(name)
    say = domain.publisher(topic, profile)
    sent = 0
    deadline_s = time.monotonic() + TIMEOUT_S
    # A warning comes every 5 s and tells the count; the first few payloads may be lost.
    while last_count(node) <= len(BAD):
        assert time.monotonic() < deadline_s, node.output
        say(BAD[sent % len(BAD)])
        sent += 1
        domain.listen_for(0.1)

    def goes_on() -> bool:
        say(good)  # again and again: BEST_EFFORT may lose it
        return bool(node.matching(sign_of_life))

    domain.wait_until(goes_on, f"{name} says {sign_of_life!r}")

    assert {match[1] for match in warnings(node)} == {topic}
    assert int(warnings(node)[0][2]) == 1
    assert last_count(node) <= sent


def last_count(node) -> int:
    return max((int(match[2]) for match in warnings(node)), default=0)


def warnings(node) -> list[re.Match]:
    found = (re.search(COUNT, line.text) for line in node.matching("Dropped a malformed"))
    return [match for match in found if match]
