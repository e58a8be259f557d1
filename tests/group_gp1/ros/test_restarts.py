"""Counts when a robot or a dispatcher starts again: each task once."""

from __future__ import annotations

import json

import pytest

from group_gp1 import qos, topics
from group_gp1.logic.messages import TaskAssignment

pytestmark = pytest.mark.thorough

ROOMY = 100  # depth that keeps everything that is sent until both sides are connected
BACKLOG = 8  # tasks that a robot may do in one go: a status that is not lost lists the last ten


def test_a_task_that_a_restarted_robot_does_again_is_counted_once(domain):
    statuses = domain.record(topics.STATUS, qos.STATUS)
    assign = domain.publisher(topics.TASKS, qos.TASKS)
    monitor = domain.start("monitor", robot_ids="[robot_1]")
    robot = start_fast_robot(domain)
    domain.wait_for_line(monitor, "robot_1 is reporting")
    for number in range(1, 9):
        assign(assignment(f"a-{number}"))
        domain.wait_until(lambda n=number: f"a-{n}" in done_ids(statuses), f"task {number} is done")
    domain.wait_for_line(monitor, "robot_1: 8 tasks")  # which may have lost statuses until here

    robot.stop()
    again = start_fast_robot(domain)  # finds the last five in the backlog
    domain.wait_until(lambda: len(again.matching("complete")) == 5, "five tasks are done again")
    assign(assignment("a-9"))

    domain.wait_for_line(monitor, "Fleet report -- robot_1: 9 tasks")
    domain.wait_for_line(again, "Late joiner: received 5 assignments")


def test_tasks_of_a_restarted_dispatcher_are_counted_as_new_ones(domain):
    monitor = domain.start("monitor", robot_ids="[robot_1]")
    robot = start_fast_robot(domain)
    domain.wait_for_line(monitor, "robot_1 is reporting")
    for _ in range(2):  # the second one counts its tasks from 1 again
        before = len(robot.matching("complete"))
        dispatcher = start_fast_dispatcher(domain)
        domain.wait_until(
            lambda n=before: len(robot.matching("complete")) >= n + 6, "six tasks are done"
        )
        dispatcher.stop()

    def all_counted() -> bool:
        # The robot's own count: the last assignment may be lost with its dispatcher.
        taken = len(robot.matching("Received task"))
        return bool(monitor.matching(f"Fleet report -- robot_1: {taken} tasks"))

    # Statuses may be lost; each repeats the last ten tasks until the next one.
    domain.wait_until(all_counted, "the monitor has counted each task")


@pytest.mark.parametrize("end", ["stop", "kill"])
def test_a_restarted_publisher_that_does_not_match_is_counted_once(domain, end):
    probe = domain.start("qos_probe")
    mismatch = "Incompatible QoS on /fleet/status: RELIABILITY"
    robot = start_fast_robot(domain)
    domain.wait_for_line(probe, f"{mismatch}, 1 publishers do not match")
    for restarts in (1, 2, 3):
        getattr(robot, end)()
        robot = start_fast_robot(domain)
        domain.wait_until(
            lambda n=restarts: len(probe.matching(mismatch)) > n, "the mismatch is explained again"
        )
    assert len(probe.matching(f"{mismatch}, 1 publishers do not match")) == 4
    domain.wait_for_line(probe, "Received 0 messages on /fleet/status, 1 publishers do not match")


def start_fast_robot(domain):
    settings = {"task_duration_s": 0.0, "status_period_s": 0.1, "task_queue_depth": ROOMY}
    return domain.start("robot_1", **settings)


def start_fast_dispatcher(domain):
    settings = {"dispatch_rate_hz": 5.0, "task_history_depth": BACKLOG, "robot_ids": "[robot_1]"}
    return domain.start("dispatcher", **settings)


def assignment(task_id: str) -> str:
    return TaskAssignment(robot_id="robot_1", task="pick_shelf_A3", task_id=task_id).to_json()


def done_ids(statuses) -> set[str]:
    return {task_id for heard in statuses for task_id in json.loads(heard.text)["completed"]}
