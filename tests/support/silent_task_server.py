"""An action server whose answers are lost: only the status topic reports the end of a goal.

`python -m tests.support.silent_task_server` prints `ready` and runs until its stdin is closed. It
accepts and ends every goal; of the requests for a result only the second one is answered.
"""

from __future__ import annotations

import contextlib
import sys
import threading

import rclpy
from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from fleet_interfaces.action import ExecuteTask
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_action_status_default

END = threading.Event()


class SilentServer(Node):
    def __init__(self) -> None:
        super().__init__("silent_server")
        kinds, group = ExecuteTask.Impl, ReentrantCallbackGroup()
        self._is_asked = False
        self._status = self.create_publisher(
            GoalStatusArray, "execute/_action/status", qos_profile_action_status_default
        )
        self._feedback = self.create_publisher(
            kinds.FeedbackMessage, "execute/_action/feedback", 10
        )
        for name, kind, callback in (
            ("send_goal", kinds.SendGoalService, self._accept),
            ("get_result", kinds.GetResultService, self._get_result),
            ("cancel_goal", kinds.CancelGoalService, lambda request, response: response),
        ):
            self.create_service(kind, f"execute/_action/{name}", callback, callback_group=group)

    def _accept(self, request: object, response: object) -> object:
        self._publish(request.goal_id, GoalStatus.STATUS_EXECUTING)
        END.wait()
        return response

    def _get_result(self, request: object, response: object) -> object:
        if not self._is_asked:
            self._is_asked = True
            self._publish(request.goal_id, GoalStatus.STATUS_SUCCEEDED)
            END.wait()
        response.status = GoalStatus.STATUS_SUCCEEDED
        return response

    def _publish(self, goal_id: object, status: int) -> None:
        shown = GoalStatus(goal_info=GoalInfo(goal_id=goal_id), status=status)
        self._status.publish(GoalStatusArray(status_list=[shown]))


def wait_for_end() -> None:
    sys.stdin.read()
    END.set()
    rclpy.try_shutdown()


def main() -> None:
    """Spin until stdin ends."""
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=6)
    node = SilentServer()
    executor.add_node(node)
    threading.Thread(target=wait_for_end, daemon=True).start()
    print("ready", flush=True)
    with contextlib.suppress(ExternalShutdownException):  # stdin has ended
        executor.spin()
    node.destroy_node()


if __name__ == "__main__":
    main()
