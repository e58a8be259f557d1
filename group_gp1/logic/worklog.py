"""The current and completed tasks of one robot, as its statuses report them."""

from __future__ import annotations

from collections import deque
import itertools

from group_gp1.logic.messages import RECENTLY_COMPLETED, RobotStatus, Status, TaskAssignment


class WorkLog:
    """
    Current task and recently completed tasks of one robot.

    `run` makes the ids unique that are given to assignments without one.
    """

    def __init__(self, robot_id: str, *, run: str) -> None:
        self._run = run
        self._unnamed = itertools.count(1)
        self._completed: deque[str] = deque(maxlen=RECENTLY_COMPLETED)
        self._status = RobotStatus(
            robot_id=robot_id, status=Status.DONE, task='', task_id=None, completed=()
        )

    @property
    def status(self) -> RobotStatus:
        """The status to publish."""
        return self._status

    def begin(self, assignment: TaskAssignment) -> RobotStatus:
        """Start a task; returns the busy status."""
        task_id = assignment.task_id or f'{self._run}-{next(self._unnamed)}'
        self._status = self._new_status(Status.BUSY, assignment.task, task_id)
        return self._status

    def finish(self) -> RobotStatus:
        """End the current task; returns the done status. ValueError without a task."""
        task_id = self._status.task_id
        if task_id is None:
            raise ValueError('finish() without begin()')
        self._completed.append(task_id)
        self._status = self._new_status(Status.DONE, self._status.task, task_id)
        return self._status

    def _new_status(self, status: Status, task: str, task_id: str) -> RobotStatus:
        return RobotStatus(
            robot_id=self._status.robot_id,
            status=status,
            task=task,
            task_id=task_id,
            completed=tuple(self._completed),
        )
