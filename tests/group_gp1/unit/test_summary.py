"""The report about many robots."""

from __future__ import annotations

from group_gp1.logic.bookkeeping import FleetBooks
from group_gp1.logic.messages import RobotStatus, Status

HUNDRED = [f"robot_{number:03}" for number in range(1, 101)]


def status(robot_id: str, state: Status, *completed: str) -> RobotStatus:
    return RobotStatus(
        robot_id=robot_id, status=state, task="", task_id="x-0", completed=tuple(completed)
    )


def test_a_fleet_that_has_not_started():
    books = FleetBooks(HUNDRED, silence_timeout_s=5.0, now_s=0.0)

    assert str(books.summary(now_s=1.0)) == (
        "Fleet report -- 100 robots: 0 busy, 0 idle, 0 silent, 100 not started; 0 tasks; "
        "not started: robot_001, robot_002, robot_003, robot_004, robot_005 and 95 more"
    )


def test_states_silent_robots_and_those_with_the_fewest_tasks():
    books = FleetBooks(HUNDRED, silence_timeout_s=5.0, now_s=0.0)
    books.record(status("robot_001", Status.BUSY), now_s=0.0)
    books.record(status("robot_002", Status.BUSY), now_s=3.0)
    books.new_silences(now_s=8.5)
    for number, robot_id in enumerate(HUNDRED[2:99]):
        state = Status.BUSY if number < 60 else Status.DONE
        ids = [f"{robot_id}-1", f"{robot_id}-2"][: 1 if number in (3, 4) else 2]
        books.record(status(robot_id, state, *ids), now_s=9.0)

    text = str(books.summary(now_s=9.5))

    assert text.startswith(
        "Fleet report -- 100 robots: 60 busy, 37 idle, 2 silent, 1 not started; "
    )
    assert "; silent: robot_001 (10 s), robot_002 (6 s); not started: robot_100; " in text
    assert text.endswith("fewest tasks: 1 by robot_006, robot_007")
    assert len(text) < 250
