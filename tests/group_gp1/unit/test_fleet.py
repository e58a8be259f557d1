"""The robots of a warehouse: generated, and from a file."""

from __future__ import annotations

from pathlib import Path

import pytest

from group_gp1.logic.fleet import MAX_ROBOTS, FleetError, FleetRobot, generate, read


def write(folder: Path, text: str) -> str:
    path = folder / "fleet.yaml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_a_hundred_robots_have_names_that_sort_and_different_durations():
    robots = generate(100, seed=0)

    assert [one.robot_id for one in robots] == sorted(f"robot_{n:03}" for n in range(1, 101))
    assert len({one.task_duration_s for one in robots}) > 50
    assert all(0.3 <= one.task_duration_s <= 2.0 for one in robots)


def test_the_same_seed_makes_the_same_robots_however_many_there_are():
    assert generate(100, seed=3)[:10] == generate(10, seed=3)
    assert generate(10, seed=3) != generate(10, seed=4)


@pytest.mark.parametrize("number", [0, -1, MAX_ROBOTS + 1])
def test_a_number_of_robots_that_is_not_possible(number):
    with pytest.raises(FleetError, match=f"robots is {number}, and not a number from 1 to 500"):
        generate(number, seed=0)


def test_a_fleet_file_gives_each_robot_what_is_its_own_and_the_rest_of_the_fleet(tmp_path):
    path = write(
        tmp_path,
        "seed: 7\nstatus_period_s: 2\n"
        "robots:\n"
        "  - robot_1\n"
        "  - {id: forklift, task_duration_s: 3, task_spread: 0.2, seed: 1}\n",
    )

    plain, forklift = read(path)

    assert (plain.robot_id, plain.seed, plain.status_period_s) == ("robot_1", 7, 2.0)
    assert 0.3 <= plain.task_duration_s <= 2.0
    assert forklift == FleetRobot(
        robot_id="forklift", task_duration_s=3.0, task_spread=0.2, status_period_s=2.0, seed=1
    )
    assert forklift.longest_silence_s == pytest.approx(3.6 + 2.0)


def test_the_seed_of_the_command_line_is_for_a_file_without_one(tmp_path):
    path = write(tmp_path, "robots: [robot_1]\n")

    assert read(path, seed=5) == [
        FleetRobot(robot_id="robot_1", task_duration_s=read(path, 5)[0].task_duration_s, seed=5)
    ]
    assert read(path, seed=5) != read(path, seed=6)


def test_all_mistakes_of_a_file_are_told_with_their_lines(tmp_path):
    path = write(
        tmp_path,
        "sed: 4\n"
        "task_duration_s: fast\n"
        "robots:\n"
        "  - {id: robot_1, task_duration: 3}\n"
        "  - {id: robot-2}\n"
        "  - robot_1\n"
        "  - {task_duration_s: 1}\n"
        "  - dispatcher\n"
        "  - [robot_3]\n"
        "  - {id: robot_4, seed: 1.5}\n",
    )

    with pytest.raises(FleetError) as caught:
        read(path)

    assert str(caught.value).replace(path, "F").splitlines() == [
        "F:1: a fleet file has no 'sed'; did you mean 'seed'?",
        "F:2: task_duration_s: 'fast' is not a number from 0 to 3600",
        "F:4: a robot has no 'task_duration'; did you mean 'task_duration_s'?",
        "F:5: 'robot-2' is no id of a robot: letters, digits and _, and a letter first; "
        "did you mean robot_2?",
        "F:6: 'robot_1' is already the id of the robot in line 4",
        "F:7: a robot needs 'id', the name of its node",
        "F:8: 'dispatcher' is the name of another node of the fleet",
        "F:9: a robot is a mapping with: id, task_duration_s, task_spread, status_period_s, seed",
        "F:10: seed: '1.5' is not a whole number from 0 to 2.14748e+09",
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "F:1: a fleet file is a mapping with: robots, "),
        ("seed: 1\n", "F:1: a fleet file needs 'robots': "),
        ("robots: []\n", "F:1: 'robots' is a list with at least one robot"),
        ("robots: 100\n", "F:1: 'robots' is a list with at least one robot"),
        ("robots:\n - {id: a\n - b\n", "F:4: expected "),
        ("seed: 1\nseed: 2\nrobots: [a]\n", "F:2: 'seed' is here twice"),
        ("robots: [" + "a, " * 501 + "]\n", "F:1: 501 robots, and more than 500"),
    ],
)
def test_a_file_that_is_no_fleet(tmp_path, text, message):
    path = write(tmp_path, text)

    with pytest.raises(FleetError) as caught:
        read(path)

    assert str(caught.value).replace(path, "F").startswith(message)


def test_a_file_that_is_nested_too_deeply(tmp_path):
    with pytest.raises(FleetError, match=r"the fleet file '.*' is nested too deeply"):
        read(write(tmp_path, "[" * 50_000))


def test_a_file_that_cannot_be_read(tmp_path):
    with pytest.raises(FleetError, match=r"cannot read the fleet file '.*': No such file"):
        read(str(tmp_path / "none.yaml"))
    (tmp_path / "fleet.yaml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FleetError, match=r"is not text in UTF-8|unacceptable"):
        read(str(tmp_path / "fleet.yaml"))
