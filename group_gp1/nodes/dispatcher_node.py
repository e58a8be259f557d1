"""
The dispatcher: assigns tasks to the robots in turn.

With three robots it assigns whether they are there or not, as the scenario has it. With
`assign_when_idle` it reads their statuses, and assigns to those that are there and idle.
"""

from __future__ import annotations

import time
import uuid

from group_gp1 import qos, settings, topics
from group_gp1.logic.messages import MessageError, RobotStatus, TaskAssignment
from group_gp1.logic.rejects import Rejects
from group_gp1.logic.roster import Roster
from group_gp1.logic.rotation import Rotation
from rclpy.node import Node
from std_msgs.msg import String

SUMMARY_PERIOD_S = 10.0


class Dispatcher(Node):
    """Publishes one assignment per tick on `/fleet/tasks`."""

    def __init__(self) -> None:
        super().__init__('dispatcher')
        rate_hz = settings.number(
            self, 'dispatch_rate_hz', 1.0, low=0.01, high=1000.0, unit='Hz', about='Assignments'
        )
        robot_ids = settings.names(
            self,
            'robot_ids',
            ['robot_1', 'robot_2', 'robot_3'],
            about='Robots that get tasks, in this order',
        )
        depth = settings.whole_number(
            self,
            'task_history_depth',
            qos.TASKS_DEPTH,
            low=1,
            high=qos.MAX_DEPTH,
            unit='messages',
            about='Assignments kept for robots that join late',
        )
        # the run makes task ids unique after a restart, when the dispatcher counts from 1 again
        run = uuid.uuid4().hex[:8]
        self._rotation = Rotation(robot_ids, run=run)
        self._roster = self._read_statuses(robot_ids, run)
        self._tasks = self.create_publisher(String, topics.TASKS, qos.tasks_profile(depth))
        self._timer = self.create_timer(1.0 / rate_hz, self._dispatch)

    def _read_statuses(self, robot_ids: list[str], run: str) -> Roster | None:
        timeout_s = settings.silence_timeout_s(self)
        depth = settings.status_queue_depth(self)
        about = 'Assign only to robots that report and have done their last task'
        if not settings.switch(self, 'assign_when_idle', about=about):
            return None
        self._rejects = Rejects(self.get_logger(), topics.STATUS)
        self._statuses = self.create_subscription(
            String, topics.STATUS, self._record, qos.status_profile(depth)
        )
        self._summary_timer = self.create_timer(SUMMARY_PERIOD_S, self._summarize)
        return Roster(robot_ids, run=run, silence_timeout_s=timeout_s)

    def _record(self, message: String) -> None:
        assert self._roster is not None
        try:
            self._roster.record(RobotStatus.from_json(message.data), time.monotonic())
        except MessageError as error:
            self._rejects.add(error)

    def _summarize(self) -> None:
        assert self._roster is not None
        self.get_logger().info(self._roster.summary())

    def _next(self) -> TaskAssignment | None:
        if self._roster is None:
            return self._rotation.next_assignment()
        assignment = self._roster.next_assignment(time.monotonic())
        while self._roster.notices:
            self.get_logger().warning(self._roster.notices.popleft())
        return assignment

    def _dispatch(self) -> None:
        assignment = self._next()
        if assignment is None:
            return
        self._tasks.publish(String(data=assignment.to_json()))
        self.get_logger().info(f'Assigned task {assignment.task} to {assignment.robot_id}')
