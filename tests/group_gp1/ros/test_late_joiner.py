"""What TRANSIENT_LOCAL hands to a robot that starts late, while nothing new is assigned."""

from __future__ import annotations

from group_gp1 import qos, topics
from group_gp1.logic.messages import TaskAssignment


def test_a_late_joiner_receives_exactly_the_last_five_assignments(domain):
    assign = domain.publisher(topics.TASKS, qos.TASKS)
    robot_ids = ["robot_3", "robot_1"] * 4
    for number, robot_id in enumerate(robot_ids):
        assign(assignment(number, robot_id))
    robot = domain.start("robot_3")
    domain.wait_until(lambda: len(robot.matching("Backlog")) == 5, "it has taken the backlog")
    assign(assignment(8, "robot_1"))  # it sums up when the first new one comes
    domain.wait_for_line(robot, "Late joiner: received 5 assignments")

    log = robot.log_texts()
    backlog = [text.partition(": ")[2].partition(",")[0] for text in log if "Backlog" in text]
    assert backlog == [f"task_{n} for {robot_ids[n]}" for n in range(3, 8)]
    taken = [text.split()[2] for text in log if text.startswith("Received task")]
    assert taken == ["task_4", "task_6"]


def assignment(number: int, robot_id: str) -> str:
    task = TaskAssignment(robot_id=robot_id, task=f"task_{number}", task_id=f"a-{number}")
    return task.to_json()
