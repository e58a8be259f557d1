"""Assigns tasks in turn to the robots that are there and idle, and accounts for every task."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
import itertools

from group_gp1.logic.messages import RobotStatus, Status, TaskAssignment
from group_gp1.logic.rotation import TASKS


@dataclass(slots=True)
class _Robot:
    """`work` is its unfinished task; all times are seconds of one monotonic clock."""

    robot_id: str
    seen_s: float | None = None  # None: it has not reported, or is silent
    work: TaskAssignment | None = None
    assigned_s: float = 0.0
    is_missed: bool = False  # it has reported before
    is_busy: bool = False  # maybe with a task of a dispatcher that has been restarted

    @property
    def is_free(self) -> bool:
        return self.seen_s is not None and self.work is None and not self.is_busy


class Roster:
    """
    The robots in turn. A robot gets a task if it reports, and has done its last one.

    A task that its robot cannot do any more is assigned again, with a new id: the robot is silent
    for `silence_timeout_s`, or works on something else that long after the assignment (it has been
    restarted, or the message was lost). `notices` are lines for the log, which the caller takes.
    """

    def __init__(
        self,
        robot_ids: Sequence[str],
        *,
        run: str,
        silence_timeout_s: float,
        tasks: Sequence[str] = TASKS,
    ) -> None:
        self._robots = {robot_id: _Robot(robot_id) for robot_id in robot_ids}
        self._order = deque(self._robots.values())  # the next one first
        self._silence_timeout_s = silence_timeout_s
        self._tasks = itertools.cycle(tasks)
        self._again: deque[str] = deque()
        self._numbers = itertools.count(1)
        self._run = run
        self.notices: deque[str] = deque()
        self.assigned = 0
        self.done = 0
        self.repeated = 0

    def record(self, status: RobotStatus, now_s: float) -> None:
        """Take note of a status; those of other robots are ignored."""
        robot = self._robots.get(status.robot_id)
        if robot is None:
            return
        if robot.seen_s is None and robot.is_missed:
            self.notices.append(f'{robot.robot_id} reports again, and gets tasks')
        robot.seen_s = now_s
        robot.is_missed = False
        robot.is_busy = status.status is Status.BUSY
        if robot.work is None:
            return
        if _has_done(status, robot.work.task_id):
            self.done += 1
            robot.work = None
        elif status.task_id != robot.work.task_id and self._is_overdue(robot.assigned_s, now_s):
            self._give_back(robot, 'was not done')

    def next_assignment(self, now_s: float) -> TaskAssignment | None:
        """Return the next assignment, or None if no robot is there and idle."""
        self._note_silent(now_s)
        robot = next((one for one in self._order if one.is_free), None)
        if robot is None:
            return None
        self._order.rotate(-self._order.index(robot) - 1)
        task = self._again.popleft() if self._again else next(self._tasks)
        task_id = f'{self._run}-{next(self._numbers)}'
        robot.work = TaskAssignment(robot_id=robot.robot_id, task=task, task_id=task_id)
        robot.assigned_s = now_s
        self.assigned += 1
        return robot.work

    def summary(self) -> str:
        """Say what became of all assignments."""
        in_work = sum(robot.work is not None for robot in self._robots.values())
        there = sum(robot.seen_s is not None for robot in self._robots.values())
        return (
            f'Dispatched {self.assigned} tasks: {self.done} done, {in_work} in work, '
            f'{self.repeated} given back, {len(self._again)} of them waiting; '
            f'{there} of {len(self._robots)} robots report'
        )

    def _note_silent(self, now_s: float) -> None:
        for robot in self._robots.values():
            if robot.seen_s is not None and self._is_overdue(robot.seen_s, now_s):
                robot.seen_s, robot.is_missed = None, True
                self.notices.append(
                    f'{robot.robot_id} has not reported in {self._silence_timeout_s:.1f} s: '
                    'it gets no tasks until it does'
                )
                if robot.work is not None:
                    self._give_back(robot, 'will not be done')

    def _is_overdue(self, since_s: float, now_s: float) -> bool:
        return now_s - since_s >= self._silence_timeout_s

    def _give_back(self, robot: _Robot, why: str) -> None:
        work = robot.work
        assert work is not None
        robot.work = None
        self.repeated += 1
        self._again.append(work.task)
        self.notices.append(
            f'Task {work.task} ({work.task_id}) of {robot.robot_id} {why}: it is assigned again'
        )


def _has_done(status: RobotStatus, task_id: str | None) -> bool:
    is_last = status.status is Status.DONE and status.task_id == task_id
    return is_last or task_id in (status.completed or ())
