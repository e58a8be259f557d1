"""The monitor's counts: each task once, warnings about silence, thread safety."""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest
from hypothesis import given
from hypothesis import strategies as st

from group_gp1.logic.bookkeeping import FleetBooks
from group_gp1.logic.messages import RECENTLY_COMPLETED, RobotStatus, Status


def books(*robot_ids: str) -> FleetBooks:
    return FleetBooks(robot_ids, silence_timeout_s=5.0, now_s=100.0)


def done(
    task_id: str, *, robot_id: str = "robot_1", completed: tuple[str, ...] = ()
) -> RobotStatus:
    return RobotStatus(
        robot_id=robot_id, status=Status.DONE, task="t", task_id=task_id, completed=completed
    )


def plain(status: Status, task: str) -> RobotStatus:
    """A status with nothing but the fields of the scenario."""
    return RobotStatus(robot_id="robot_1", status=status, task=task)


def warnings(ledger: FleetBooks, now_s: float) -> list[str]:
    return [str(silence) for silence in ledger.new_silences(now_s=now_s)]


def test_expected_robots_are_listed_in_order_before_they_report():
    assert list(books("robot_2", "robot_1").counts().items()) == [("robot_2", 0), ("robot_1", 0)]


def test_a_repeated_done_counts_once():
    ledger = books("robot_1")
    for now_s in (101.0, 102.0, 103.0):
        ledger.record(done("a-1"), now_s=now_s)

    assert ledger.counts() == {"robot_1": 1}


def test_a_lost_done_is_made_good_by_the_next_status():
    ledger = books("robot_1")
    ledger.record(done("a-3", completed=("a-1", "a-2", "a-3")), now_s=101.0)

    assert ledger.counts() == {"robot_1": 3}


def test_an_idle_robot_without_a_task_counts_nothing():
    ledger = books("robot_1")
    idle = RobotStatus(robot_id="robot_1", status=Status.DONE, task="", completed=())
    ledger.record(idle, now_s=101.0)

    assert ledger.counts() == {"robot_1": 0}


def test_a_busy_robot_counts_only_what_it_completed_before():
    ledger = books("robot_1")
    busy = RobotStatus(
        robot_id="robot_1", status=Status.BUSY, task="t", task_id="a-2", completed=("a-1",)
    )
    ledger.record(busy, now_s=101.0)

    assert ledger.counts() == {"robot_1": 1}


def test_an_unexpected_robot_is_counted_and_listed_last():
    ledger = books("robot_1")
    ledger.record(done("a-1", robot_id="robot_9"), now_s=101.0)

    assert list(ledger.counts().items()) == [("robot_1", 0), ("robot_9", 1)]


@pytest.mark.parametrize(
    ("story", "count"),
    [
        ([(Status.DONE, "a"), (Status.DONE, "a")], 1),
        ([(Status.DONE, "a"), (Status.DONE, "b")], 2),
        ([(Status.DONE, "a"), (Status.BUSY, "a"), (Status.DONE, "a")], 2),
        ([(Status.BUSY, "a"), (Status.BUSY, "b")], 0),
        ([(Status.DONE, "")], 0),
    ],
    ids=["repeated", "two tasks", "same task again", "never done", "no task"],
)
def test_a_sender_with_only_the_named_fields_is_counted_by_its_changes(story, count):
    ledger = books("robot_1")
    for status, task in story:
        ledger.record(plain(status, task), now_s=101.0)

    assert ledger.counts() == {"robot_1": count}


@given(st.lists(st.integers(0, RECENTLY_COMPLETED - 1), max_size=40), st.integers(1, 3))
def test_any_loss_shorter_than_the_memory_of_a_status_is_made_good(losses, repeats):
    ledger = books("robot_1")
    recent: deque[str] = deque(maxlen=RECENTLY_COMPLETED)
    total = 0
    for lost in losses:  # so many statuses vanish before the next one arrives
        for _ in range(lost + 1):
            total += 1
            recent.append(f"a-{total}")
        for _ in range(repeats):
            ledger.record(done(f"a-{total}", completed=tuple(recent)), now_s=101.0)

    assert ledger.counts() == {"robot_1": total}


def test_the_memory_of_ids_is_bounded_and_the_count_is_not():
    ledger = books("robot_1")
    for number in range(3000):
        ledger.record(done(f"a-{number}"), now_s=101.0)
    ledger.record(done("a-2999"), now_s=101.0)

    assert ledger.counts() == {"robot_1": 3000}


def test_silence_is_warned_about_once_at_each_mark():
    ledger = books("robot_2")

    assert warnings(ledger, 104.9) == []
    assert warnings(ledger, 105.0) == ["robot_2 has not reported in 5.0 s"]
    assert warnings(ledger, 109.9) == []
    assert warnings(ledger, 110.1) == ["robot_2 has not reported in 10.0 s"]
    assert warnings(ledger, 119.9) == []
    assert warnings(ledger, 120.0) == ["robot_2 has not reported in 20.0 s"]


def test_a_robot_that_never_reported_has_time_to_start():
    ledger = FleetBooks(["robot_2"], silence_timeout_s=5.0, start_grace_s=7.0, now_s=100.0)

    assert warnings(ledger, 111.9) == []
    assert warnings(ledger, 112.0) == ["robot_2 has not reported in 5.0 s"]
    assert warnings(ledger, 116.9) == []
    assert warnings(ledger, 117.0) == ["robot_2 has not reported in 10.0 s"]


@pytest.mark.parametrize("heard_s", [101.0, 106.0])
def test_the_time_to_start_ends_with_the_first_status(heard_s: float):
    ledger = FleetBooks(["robot_2"], silence_timeout_s=5.0, start_grace_s=7.0, now_s=100.0)
    ledger.record(done("a-1", robot_id="robot_2"), now_s=heard_s)

    assert warnings(ledger, heard_s + 4.9) == []
    assert warnings(ledger, heard_s + 5.0) == ["robot_2 has not reported in 5.0 s"]


def test_a_long_silence_is_warned_about_once_a_minute():
    ledger = books("robot_2")
    marks = [now_s - 100 for now_s in range(101, 500) if ledger.new_silences(now_s=now_s)]

    assert marks == [5, 10, 20, 40, 80, 140, 200, 260, 320, 380]


def test_several_missed_marks_give_one_warning():
    assert warnings(books("robot_2"), 123.0) == ["robot_2 has not reported in 20.0 s"]


def test_a_robot_that_comes_back_is_noted_and_watched_again():
    ledger = books("robot_1")
    ledger.record(done("a-1"), now_s=101.0)
    ledger.new_silences(now_s=107.0)
    arrival = ledger.record(done("a-1"), now_s=109.5)

    assert str(arrival) == "robot_1 is reporting again after 8.5 s"
    assert warnings(ledger, 114.4) == []
    assert warnings(ledger, 114.5) == ["robot_1 has not reported in 5.0 s"]


def test_a_robot_is_noted_at_its_first_status_and_then_no_more():
    ledger = books("robot_1")

    assert str(ledger.record(done("a-1"), now_s=101.0)) == "robot_1 is reporting"
    assert ledger.record(done("a-1"), now_s=102.0) is None


@pytest.fixture
def eager_threads() -> Iterator[None]:
    """Let the interpreter change threads as often as it can, so that races show."""
    usual_s = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(usual_s)


@pytest.mark.usefixtures("eager_threads")
def test_threads_may_record_report_and_check_at_the_same_time():
    ledger = books("robot_1")

    def record(prefix: str) -> None:
        for number in range(1000):
            ledger.record(done(f"{prefix}-{number}"), now_s=101.0)
            ledger.record(done("x", robot_id=f"{prefix}-{number}"), now_s=101.0)

    def look(prefix: str) -> None:
        for _ in range(300):
            ledger.counts()
            ledger.new_silences(now_s=101.0)

    with ThreadPoolExecutor(4) as pool:
        jobs = [pool.submit(work, name) for work in (record, look) for name in "ab"]
        for job in jobs:
            job.result()  # raises what the thread raised

    assert ledger.counts()["robot_1"] == 2000
    assert sum(ledger.counts().values()) == 4000
