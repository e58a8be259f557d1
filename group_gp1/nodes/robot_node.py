"""The robot: executes the tasks that are addressed to it, one after the other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
import random
import uuid

from group_gp1 import qos, runner, settings, topics
from group_gp1.logic.backlog import Backlog
from group_gp1.logic.messages import MessageError, RobotStatus, TaskAssignment
from group_gp1.logic.rejects import Rejects
from group_gp1.logic.worklog import WorkLog
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node
from std_msgs.msg import String


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotProfile:
    """What distinguishes the robots."""

    robot_id: str | None  # None: the name that the node gets from its launch file
    task_duration_s: float


class Robot(Node):
    """Receives assignments on `/fleet/tasks` and reports on `/fleet/status`."""

    def __init__(self, profile: RobotProfile) -> None:
        super().__init__(profile.robot_id or 'robot')
        self._robot_id = profile.robot_id or self.get_name()
        self._work = WorkLog(self._robot_id, run=uuid.uuid4().hex[:8])
        self._backlog = Backlog(self._robot_id)
        self._rejects = Rejects(self.get_logger(), topics.TASKS)
        self._task_spread = self._declare_task_spread()
        self._chance = random.Random(f'{self._declare_seed()}:{self._robot_id}')
        self._task_duration_s = self._declare_task_duration(profile.task_duration_s)
        # One group for both callbacks, so that they never overlap with any executor: the
        # subscription writes the current task (in self._work), and the timer reads it.
        group = MutuallyExclusiveCallbackGroup()
        self._statuses = self.create_publisher(
            String, topics.STATUS, qos.STATUS, qos_overriding_options=qos.DEPTH_PARAMETER
        )
        self._tasks = self.create_subscription(
            String,
            topics.TASKS,
            self._take,
            qos.tasks_profile(self._declare_queue_depth()),
            callback_group=group,
        )
        self._timer = self.create_timer(
            self._declare_status_period(), self._repeat_status, callback_group=group
        )

    def _take(self, message: String, info: Mapping[str, int]) -> None:
        try:
            assignment = TaskAssignment.from_json(message.data)
        except MessageError as error:
            self._rejects.add(error)
            return
        news = self._backlog.note(
            assignment,
            sent_ns=info['source_timestamp'],
            received_ns=info['received_timestamp'],
        )
        if news:
            self.get_logger().info(news)
        if assignment.robot_id == self._robot_id:
            self._execute(assignment)

    def _execute(self, assignment: TaskAssignment) -> None:
        self.get_logger().info(f'Received task {assignment.task} -- executing...')
        self._publish(self._work.begin(assignment))
        if not runner.nap(self._next_duration_s()):  # simulates the work
            return  # interrupted: the task is not done, and the context is shut down
        self._publish(self._work.finish())
        self.get_logger().info(f'Task {assignment.task} complete')

    def _next_duration_s(self) -> float:
        return self._task_duration_s * self._chance.uniform(
            1.0 - self._task_spread, 1.0 + self._task_spread
        )

    def _repeat_status(self) -> None:
        """Report an idle robot too, and make up for lost statuses."""
        self._publish(self._work.status)

    def _publish(self, status: RobotStatus) -> None:
        self._statuses.publish(String(data=status.to_json()))

    def _declare_task_duration(self, default_s: float) -> float:
        return settings.number(
            self,
            'task_duration_s',
            default_s,
            low=0.0,
            high=3600.0,
            unit='s',
            about='How long one task takes',
        )

    def _declare_task_spread(self) -> float:
        return settings.number(
            self,
            'task_spread',
            0.0,
            low=0.0,
            high=1.0,
            unit='of task_duration_s',
            about='How much longer or shorter than usual a task may take',
        )

    def _declare_seed(self) -> int:
        return settings.whole_number(
            self,
            'seed',
            0,
            low=0,
            high=2**31 - 1,
            unit='number',
            about='The same durations with the same seed; task_spread says how much they differ',
        )

    def _declare_status_period(self) -> float:
        return settings.number(
            self,
            'status_period_s',
            1.0,
            low=0.05,
            high=60.0,
            unit='s',
            about='How often the current status is repeated',
        )

    def _declare_queue_depth(self) -> int:
        return settings.whole_number(
            self,
            'task_queue_depth',
            qos.TASKS_DEPTH,
            low=1,
            high=qos.MAX_DEPTH,
            unit='messages',
            about='Assignments that wait while a task is executed; older ones are dropped',
        )
