"""The robot: executes one task at a time, and reports its state."""

from __future__ import annotations

from collections import deque
from threading import Event, Lock
from typing import Any

from fleet_interfaces.action import ExecuteTask
from fleet_interfaces.msg import RobotStatus, TaskAssignment
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.node import Node

from fleet_nodes.runner import WaitingExecutor, run

STEP_S = 0.1
STATUS_PERIOD_S = 1.0
REMEMBERED = 10  # the bound of RobotStatus.finished


class Robot(Node):
    """Answers the action `~/execute_task`, and publishes on `/fleet/status`.

    The node's name is the robot's id: set it with `name` in a launch file.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__("robot", **options)
        self._task_duration_s = self.declare_parameter("task_duration_s", 0.5).value
        self._lock = Lock()  # the threads of a goal and of the timer share what follows
        self._is_busy = False
        self._stop = Event()
        self._assignment = TaskAssignment(robot_id=self.get_name())
        self._finished: deque[int] = deque(maxlen=REMEMBERED)
        self._statuses = self.create_publisher(RobotStatus, "/fleet/status", 10)
        self._timer = self.create_timer(STATUS_PERIOD_S, self._report)
        self._server = ActionServer(
            self,
            ExecuteTask,
            "~/execute_task",
            execute_callback=self._execute,
            goal_callback=self._consider,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            # Feedback, results and requests to cancel pass while a task is executed.
            callback_group=ReentrantCallbackGroup(),
        )

    def stop(self) -> bool:
        """End the task, and reject others; whether it has ended."""
        with self._lock:
            self._stop.set()
            return not self._is_busy

    def _consider(self, goal: ExecuteTask.Goal) -> GoalResponse:
        with self._lock:
            is_mine = goal.assignment.robot_id == self.get_name()
            if not is_mine or self._is_busy or self._stop.is_set():
                return GoalResponse.REJECT
            self._is_busy, self._assignment = True, goal.assignment
            return GoalResponse.ACCEPT

    def _execute(self, goal: ServerGoalHandle) -> ExecuteTask.Result:
        task_id = goal.request.assignment.task_id
        self.get_logger().info(f"Executing task {task_id}")
        self._report()
        started = self.get_clock().now()
        is_done = self._work(goal)
        with self._lock:
            self._is_busy = False
            if is_done:
                self._finished.append(task_id)
        self._report()
        if is_done:
            goal.succeed()
        elif goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        self.get_logger().info(f"Task {task_id} {'complete' if is_done else 'cancelled'}")
        return ExecuteTask.Result(took=(self.get_clock().now() - started).to_msg())

    def _work(self, goal: ServerGoalHandle) -> bool:
        """Simulate the work; whether it was not ended before."""
        duration = Duration(seconds=self._task_duration_s)
        begun = self.get_clock().now()
        while (passed := self.get_clock().now() - begun) < duration:
            if goal.is_cancel_requested or self._stop.is_set():
                return False
            share = passed.nanoseconds / duration.nanoseconds
            goal.publish_feedback(ExecuteTask.Feedback(progress=share))
            self._stop.wait(STEP_S)
        return True

    def _report(self) -> None:
        with self._lock:
            status = RobotStatus(
                robot_id=self.get_name(),
                state=RobotStatus.BUSY if self._is_busy else RobotStatus.IDLE,
                assignment=self._assignment,
                finished=list(self._finished),
            )
        status.header.stamp = self.get_clock().now().to_msg()
        self._statuses.publish(status)


def main(args: list[str] | None = None) -> None:
    # Three threads: a task, requests about it, the timer.
    run(Robot, args, make_executor=lambda: WaitingExecutor(num_threads=3), stop=Robot.stop)


if __name__ == "__main__":
    main()
