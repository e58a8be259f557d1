"""The statuses of a robot while it works."""

from __future__ import annotations

import pytest

from group_gp1.logic.messages import RECENTLY_COMPLETED, Status, TaskAssignment
from group_gp1.logic.worklog import WorkLog


def task(number: int | None = None) -> TaskAssignment:
    task_id = None if number is None else f"a-{number}"
    return TaskAssignment(robot_id="robot_1", task="pick_shelf_A3", task_id=task_id)


def test_a_robot_that_never_had_a_task_is_done_with_nothing():
    status = WorkLog("robot_1", run="x").status

    assert (status.status, status.task, status.completed) == (Status.DONE, "", ())


def test_a_task_is_busy_until_it_is_finished():
    log = WorkLog("robot_1", run="x")
    busy, done = log.begin(task(1)), log.finish()

    assert (busy.status, busy.task_id, busy.completed) == (Status.BUSY, "a-1", ())
    assert (done.status, done.task_id, done.completed) == (Status.DONE, "a-1", ("a-1",))
    assert log.status == done


def test_only_the_last_completed_tasks_are_named():
    log = WorkLog("robot_1", run="x")
    for number in range(RECENTLY_COMPLETED + 2):
        log.begin(task(number))
        log.finish()

    assert log.status.completed == tuple(f"a-{n}" for n in range(2, RECENTLY_COMPLETED + 2))


def test_assignments_without_an_id_get_one_each():
    log = WorkLog("robot_1", run="x")

    assert [log.begin(task()).task_id for _ in range(2)] == ["x-1", "x-2"]


def test_a_task_that_was_not_begun_cannot_be_finished():
    with pytest.raises(ValueError, match=r"without begin"):
        WorkLog("robot_1", run="x").finish()
