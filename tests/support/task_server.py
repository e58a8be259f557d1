"""An action server for fleet_interfaces/action/ExecuteTask, which the example workspace has.

`python -m tests.support.task_server` prints `ready` and runs until its stdin is closed. The word
`task` of a goal says how it ends: `work` N feedbacks (N is the id of the task), `wait` for
its cancellation, `fail`, `refuse`.
"""

from __future__ import annotations

import contextlib
import sys
import threading

import rclpy
from builtin_interfaces.msg import Duration
from fleet_interfaces.action import ExecuteTask
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node

PERIOD_S = 0.05


class TaskServer(Node):
    def __init__(self) -> None:
        super().__init__("task_server")
        self._server = ActionServer(
            self,
            ExecuteTask,
            "execute",
            self._execute,
            callback_group=ReentrantCallbackGroup(),
            goal_callback=self._decide,
            cancel_callback=lambda goal: CancelResponse.ACCEPT,
        )

    def _decide(self, goal: ExecuteTask.Goal) -> GoalResponse:
        return GoalResponse.REJECT if goal.assignment.task == "refuse" else GoalResponse.ACCEPT

    def _execute(self, goal: object) -> ExecuteTask.Result:
        assignment = goal.request.assignment
        result = ExecuteTask.Result(took=Duration(sec=assignment.task_id))
        while assignment.task == "wait" and rclpy.ok():
            if goal.is_cancel_requested:
                goal.canceled()
                return result
            goal.publish_feedback(ExecuteTask.Feedback())
            threading.Event().wait(PERIOD_S)
        if assignment.task == "fail":
            goal.abort()
            return result
        for number in range(assignment.task_id):
            share = (number + 1) / assignment.task_id
            goal.publish_feedback(ExecuteTask.Feedback(progress=share))
            threading.Event().wait(PERIOD_S)
        goal.succeed()
        return result


def main() -> None:
    """Spin until stdin ends."""
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=4)
    node = TaskServer()
    executor.add_node(node)
    threading.Thread(target=lambda: (sys.stdin.read(), rclpy.try_shutdown()), daemon=True).start()
    print("ready", flush=True)
    with contextlib.suppress(ExternalShutdownException):  # stdin has ended
        executor.spin()
    node.destroy_node()


if __name__ == "__main__":
    main()
