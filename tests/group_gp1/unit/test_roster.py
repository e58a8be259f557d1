"""Assignments to robots that are there and idle, and what becomes of each."""

from __future__ import annotations

from group_gp1.logic.messages import RobotStatus, Status, TaskAssignment
from group_gp1.logic.roster import Roster

SILENCE_S = 5.0
HUNDRED = [f"robot_{number:03}" for number in range(1, 101)]


def make_roster(robot_ids=("robot_1", "robot_2", "robot_3")) -> Roster:
    return Roster(robot_ids, run="a", silence_timeout_s=SILENCE_S, tasks=("first", "second"))


def idle(robot_id: str, *completed: str) -> RobotStatus:
    return RobotStatus(robot_id=robot_id, status=Status.DONE, task="", completed=completed)


def busy(assignment: TaskAssignment) -> RobotStatus:
    return RobotStatus(
        robot_id=assignment.robot_id,
        status=Status.BUSY,
        task=assignment.task,
        task_id=assignment.task_id,
        completed=(),
    )


def done(assignment: TaskAssignment) -> RobotStatus:
    assert assignment.task_id is not None
    return RobotStatus(
        robot_id=assignment.robot_id,
        status=Status.DONE,
        task=assignment.task,
        task_id=assignment.task_id,
        completed=(assignment.task_id,),
    )


def test_a_robot_gets_nothing_before_it_reports():
    roster = make_roster()
    assert roster.next_assignment(0.0) is None

    roster.record(idle("robot_2"), 1.0)

    assert roster.next_assignment(1.0).robot_id == "robot_2"
    assert roster.next_assignment(1.0) is None


def test_a_hundred_robots_get_one_task_each_in_turn_and_again_when_they_are_done():
    roster = make_roster(HUNDRED)
    for robot_id in HUNDRED:
        roster.record(idle(robot_id), 0.0)

    first = [roster.next_assignment(0.1) for _ in HUNDRED]
    assert [one.robot_id for one in first] == HUNDRED
    assert len({one.task_id for one in first}) == 100
    assert roster.next_assignment(0.2) is None

    for one in reversed(first):
        roster.record(done(one), 1.0)
    assert [roster.next_assignment(1.0).robot_id for _ in HUNDRED] == HUNDRED
    assert (roster.assigned, roster.done, roster.repeated) == (200, 100, 0)


def test_a_busy_robot_is_passed_over_and_comes_in_its_turn():
    roster = make_roster()
    for robot_id in ("robot_1", "robot_2", "robot_3"):
        roster.record(idle(robot_id), 0.0)
    first, _, _ = (roster.next_assignment(0.0) for _ in range(3))
    roster.record(busy(first), 0.1)
    assert roster.next_assignment(0.2) is None

    roster.record(done(first), 0.5)

    assert roster.next_assignment(0.5).robot_id == "robot_1"


def test_a_restarted_dispatcher_waits_for_what_a_robot_does_for_the_last_one():
    roster = make_roster()
    before = TaskAssignment(robot_id="robot_1", task="first", task_id="z-9")
    roster.record(busy(before), 0.0)
    assert roster.next_assignment(0.0) is None

    roster.record(done(before), 1.0)

    assert roster.next_assignment(1.0).robot_id == "robot_1"
    assert roster.done == 0


def test_a_lost_done_is_made_up_for_by_the_next_status():
    roster = make_roster()
    roster.record(idle("robot_1"), 0.0)
    roster.next_assignment(0.0)

    roster.record(idle("robot_1", "a-1"), 2.0)

    assert roster.done == 1 and roster.next_assignment(2.0).task_id == "a-2"


def test_the_task_of_a_silent_robot_goes_to_the_next_one_and_the_robot_is_left_out():
    roster = make_roster()
    for robot_id in ("robot_1", "robot_2"):
        roster.record(idle(robot_id), 0.0)
    lost = roster.next_assignment(0.0)
    roster.record(busy(lost), 0.1)
    roster.record(idle("robot_2"), 5.0)

    again = roster.next_assignment(5.2)

    assert (again.robot_id, again.task, again.task_id) == ("robot_2", "first", "a-2")
    assert list(roster.notices) == [
        "robot_1 has not reported in 5.0 s: it gets no tasks until it does",
        "Task first (a-1) of robot_1 will not be done: it is assigned again",
    ]
    assert roster.next_assignment(5.3) is None
    roster.notices.clear()
    roster.record(idle("robot_1"), 9.0)
    assert list(roster.notices) == ["robot_1 reports again, and gets tasks"]
    assert roster.next_assignment(9.0).robot_id == "robot_1"


def test_a_task_that_a_restarted_robot_has_lost_is_assigned_again_but_not_at_once():
    roster = make_roster()
    roster.record(idle("robot_1"), 0.0)
    roster.next_assignment(0.0)
    roster.record(idle("robot_1"), 4.9)  # the assignment may still be on its way
    assert roster.repeated == 0

    roster.record(idle("robot_1"), 5.0)

    assert list(roster.notices) == [
        "Task first (a-1) of robot_1 was not done: it is assigned again"
    ]
    assert (roster.next_assignment(5.0).task, roster.assigned, roster.repeated) == ("first", 2, 1)


def test_a_long_task_is_not_assigned_again_while_its_robot_reports_it():
    roster = make_roster()
    roster.record(idle("robot_1"), 0.0)
    work = roster.next_assignment(0.0)
    for second in range(1, 60):
        roster.record(busy(work), float(second))

    assert roster.repeated == 0


def test_the_robots_of_others_are_ignored_and_the_summary_has_the_rest():
    roster = make_roster()
    roster.record(idle("stranger"), 0.0)
    roster.record(idle("robot_1"), 0.0)
    roster.next_assignment(0.0)

    assert roster.summary() == (
        "Dispatched 1 tasks: 0 done, 1 in work, 0 given back, 0 of them waiting; "
        "1 of 3 robots report"
    )
