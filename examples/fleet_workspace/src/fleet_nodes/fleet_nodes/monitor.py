"""The monitor: counts the finished tasks of every robot."""

from __future__ import annotations

from typing import Any

from fleet_interfaces.msg import RobotStatus
from fleet_interfaces.srv import CountTasks
from rclpy.node import Node

from fleet_nodes.runner import run


class Monitor(Node):
    """Reads `/fleet/status`, logs a report, and answers the service `~/count_tasks`."""

    def __init__(self, **options: Any) -> None:
        super().__init__("monitor", **options)
        period_s = self.declare_parameter("report_period_s", 2.0).value
        self._finished: dict[str, set[int]] = {}
        self._statuses = self.create_subscription(RobotStatus, "/fleet/status", self._note, 10)
        self._service = self.create_service(CountTasks, "~/count_tasks", self._count)
        self._timer = self.create_timer(period_s, self._report)

    def _note(self, status: RobotStatus) -> None:
        # A status repeats the last tasks, so one that gets lost does no harm.
        self._finished.setdefault(status.robot_id, set()).update(status.finished)

    def _count(
        self, request: CountTasks.Request, response: CountTasks.Response
    ) -> CountTasks.Response:
        response.known = request.robot_id in self._finished
        response.finished = len(self._finished.get(request.robot_id, ()))
        return response

    def _report(self) -> None:
        counts = [f"{robot_id}: {len(ids)}" for robot_id, ids in sorted(self._finished.items())]
        self.get_logger().info(f"Finished tasks: {', '.join(counts) or 'none'}")


def main(args: list[str] | None = None) -> None:
    run(Monitor, args)


if __name__ == "__main__":
    main()
