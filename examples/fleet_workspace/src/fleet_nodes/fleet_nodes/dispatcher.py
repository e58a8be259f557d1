"""The dispatcher: gives tasks to the robots in turn, and publishes each assignment."""

from __future__ import annotations

from functools import partial
from itertools import count, cycle
from typing import Any

from fleet_interfaces.action import ExecuteTask
from fleet_interfaces.msg import TaskAssignment
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.task import Future

from fleet_nodes.runner import run

TASKS = ("pick_shelf_A3", "deliver_dock_2", "scan_aisle_7", "charge")
URGENT_EVERY = 5


class Dispatcher(Node):
    """Publishes on `/fleet/tasks`; a client of the action `execute_task` of every robot."""

    def __init__(self, **options: Any) -> None:
        super().__init__("dispatcher", **options)
        robot_ids = self.declare_parameter("robot_ids", ["robot_1", "robot_2"]).value
        period_s = self.declare_parameter("period_s", 1.0).value
        self._ids, self._tasks = count(1), cycle(TASKS)
        self._idle = {
            robot_id: ActionClient(self, ExecuteTask, f"/{robot_id}/execute_task")
            for robot_id in robot_ids
        }
        self._assignments = self.create_publisher(TaskAssignment, "/fleet/tasks", 10)
        self._timer = self.create_timer(period_s, self._assign)

    def _assign(self) -> None:
        """Give the next task to the robot that has been idle for the longest time."""
        ready = (robot_id for robot_id, client in self._idle.items() if client.server_is_ready())
        robot_id = next(ready, None)
        if robot_id is None:
            return
        task_id = next(self._ids)
        assignment = TaskAssignment(
            task_id=task_id,
            task=next(self._tasks),
            robot_id=robot_id,
            priority=TaskAssignment.NORMAL if task_id % URGENT_EVERY else TaskAssignment.URGENT,
            assigned=self.get_clock().now().to_msg(),
        )
        client = self._idle.pop(robot_id)
        self._assignments.publish(assignment)
        self.get_logger().info(f"Task {task_id} ({assignment.task}) is for {robot_id}")
        sent = client.send_goal_async(ExecuteTask.Goal(assignment=assignment))
        sent.add_done_callback(partial(self._answered, client, assignment))

    def _answered(self, client: ActionClient, assignment: TaskAssignment, sent: Future) -> None:
        goal = sent.result()
        if not goal.accepted:
            self.get_logger().warn(f"{assignment.robot_id} rejected task {assignment.task_id}")
            self._idle[assignment.robot_id] = client
            return
        goal.get_result_async().add_done_callback(partial(self._ended, client, assignment))

    def _ended(self, client: ActionClient, assignment: TaskAssignment, ended: Future) -> None:
        took = ended.result().result.took
        self.get_logger().info(
            f"Task {assignment.task_id} took {took.sec + took.nanosec / 1e9:.1f} s"
        )
        self._idle[assignment.robot_id] = client


def main(args: list[str] | None = None) -> None:
    run(Dispatcher, args)


if __name__ == "__main__":
    main()
