"""The order of assignments: robots in turn, tasks in turn."""

from __future__ import annotations

from collections.abc import Sequence
import itertools

from group_gp1.logic.messages import TaskAssignment

# Seven, so that with two or three robots none always gets the same tasks.
TASKS = (
    'pick_shelf_A3',
    'deliver_dock_2',
    'pick_shelf_B1',
    'restock_aisle_4',
    'deliver_dock_1',
    'scan_shelf_C2',
    'charge_bay_5',
)


class Rotation:
    """An endless sequence of assignments with ids `<run>-1`, `<run>-2` and so on."""

    def __init__(
        self, robot_ids: Sequence[str], *, run: str, tasks: Sequence[str] = TASKS
    ) -> None:
        self._robots = itertools.cycle(robot_ids)
        self._tasks = itertools.cycle(tasks)
        self._numbers = itertools.count(1)
        self._run = run

    def next_assignment(self) -> TaskAssignment:
        return TaskAssignment(
            robot_id=next(self._robots),
            task=next(self._tasks),
            task_id=f'{self._run}-{next(self._numbers)}',
        )
