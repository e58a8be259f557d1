"""The backlog of a late joiner, by DDS time stamps."""

from __future__ import annotations

from group_gp1.logic.backlog import Backlog
from group_gp1.logic.messages import TaskAssignment

S = 1_000_000_000


def note(backlog: Backlog, robot_id: str, *, sent_s: float, received_s: float) -> str | None:
    return backlog.note(
        TaskAssignment(robot_id=robot_id, task="t"),
        sent_ns=int(sent_s * S),
        received_ns=int(received_s * S),
    )


def test_a_punctual_robot_has_no_backlog():
    backlog = Backlog("robot_1")

    assert note(backlog, "robot_1", sent_s=10.0, received_s=10.001) is None
    assert note(backlog, "robot_1", sent_s=11.0, received_s=11.001) is None
    assert backlog.received == 0


def test_a_late_joiner_logs_each_backlog_assignment_and_then_the_count():
    backlog = Backlog("robot_3")
    kept = [note(backlog, f"robot_{n}", sent_s=10.0 + n, received_s=14.5) for n in (1, 2, 3)]
    fresh = note(backlog, "robot_1", sent_s=15.0, received_s=15.001)

    assert kept[0] == "Backlog 1: t for robot_1, assigned 3.5 s before robot_3 was connected"
    assert fresh == (
        "Late joiner: received 3 assignments from before robot_3 was connected, "
        "1 of them addressed to it"
    )


def test_an_assignment_from_just_before_the_connection_belongs_to_the_backlog():
    backlog = Backlog("robot_3")
    note(backlog, "robot_1", sent_s=11.0, received_s=12.0)
    note(backlog, "robot_2", sent_s=11.999, received_s=12.0001)

    assert backlog.received == 2


def test_after_the_first_fresh_assignment_nothing_is_backlog():
    backlog = Backlog("robot_3")
    note(backlog, "robot_1", sent_s=10.0, received_s=12.0)
    note(backlog, "robot_1", sent_s=13.0, received_s=13.001)

    assert note(backlog, "robot_1", sent_s=11.0, received_s=14.0) is None
    assert (backlog.received, backlog.mine) == (1, 0)
