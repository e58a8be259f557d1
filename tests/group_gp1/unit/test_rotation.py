"""The order of assignments."""

from __future__ import annotations

from group_gp1.logic.rotation import TASKS, Rotation


def test_robots_come_in_turn():
    rotation = Rotation(["robot_1", "robot_2"], run="a")

    assert [rotation.next_assignment().robot_id for _ in range(4)] == ["robot_1", "robot_2"] * 2


def test_ids_count_up_within_the_run():
    rotation = Rotation(["robot_1"], run="a")

    assert [rotation.next_assignment().task_id for _ in range(3)] == ["a-1", "a-2", "a-3"]


def test_every_robot_gets_every_task_in_the_long_run():
    rotation = Rotation(["robot_1", "robot_2", "robot_3"], run="a")
    given = [rotation.next_assignment() for _ in range(3 * len(TASKS))]

    assert {(a.robot_id, a.task) for a in given} == {
        (f"robot_{n}", task) for n in (1, 2, 3) for task in TASKS
    }


def test_the_first_task_is_the_one_of_the_scenario():
    assert Rotation(["robot_1"], run="a").next_assignment().task == "pick_shelf_A3"
