"""What the monitor knows of every robot: completed tasks and silence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
import threading

from group_gp1.logic.messages import RobotStatus, Status
from group_gp1.logic.summary import FleetSummary

REMEMBERED_IDS = 1000  # per robot; a repeat comes from the last 10 statuses or a backlog of 5
MAX_WARNING_GAP_S = 60.0  # one line a minute for a robot that is off for long


@dataclass(frozen=True, slots=True, kw_only=True)
class Silence:
    """A robot has not reported for `silent_s`, rounded down to the mark that was passed."""

    robot_id: str
    silent_s: float

    def __str__(self) -> str:
        return f'{self.robot_id} has not reported in {self.silent_s:.1f} s'


@dataclass(frozen=True, slots=True, kw_only=True)
class Arrival:
    """A robot reports for the first time, or again after a warning and `silent_s` of silence."""

    robot_id: str
    silent_s: float | None = None

    def __str__(self) -> str:
        if self.silent_s is None:
            return f'{self.robot_id} is reporting'
        return f'{self.robot_id} is reporting again after {self.silent_s:.1f} s'


@dataclass(slots=True)
class _Account:
    """What is known of one robot; all times are seconds of one monotonic clock."""

    last_seen_s: float  # until the robot reports: when its silence begins to count
    next_mark_s: float  # length of silence at which the next warning is due
    heard: bool = False
    warned: bool = False
    status: Status = Status.DONE
    count: int = 0
    ids: dict[str, None] = field(default_factory=dict)  # a set that remembers its order
    done_without_id: str | None = None


class FleetBooks:
    """
    Counts and times of the fleet, safe to use from several threads.

    The monitor's status, report and silence callbacks run concurrently in different threads and
    callback groups; so every method takes the lock, and returns copies. No method is slow.

    `now_s` is always a time of one monotonic clock. Silence is warned about when it reaches
    `silence_timeout_s`, then after gaps that double, up to MAX_WARNING_GAP_S. The silence of an
    expected robot that has not reported yet begins after `start_grace_s`, its time to start.
    """

    def __init__(
        self,
        robot_ids: Sequence[str],
        *,
        silence_timeout_s: float,
        now_s: float,
        start_grace_s: float = 0.0,
    ) -> None:
        self._lock = threading.Lock()
        self._silence_timeout_s = silence_timeout_s
        begin_s = now_s + start_grace_s
        # expected robots first and in order: the report lists them before they ever reported
        self._accounts = {robot_id: self._new_account(begin_s) for robot_id in robot_ids}

    def record(self, status: RobotStatus, *, now_s: float) -> Arrival | None:
        """Record a status; returns an Arrival if the robot is new or was reported silent."""
        with self._lock:
            if status.robot_id not in self._accounts:
                self._accounts[status.robot_id] = self._new_account(now_s)
            account = self._accounts[status.robot_id]
            account.status = status.status
            _count(account, status)
            return self._note_seen(status.robot_id, account, now_s)

    def counts(self) -> dict[str, int]:
        """Completed tasks of every robot, each task once."""
        with self._lock:
            return {robot_id: account.count for robot_id, account in self._accounts.items()}

    def summary(self, *, now_s: float) -> FleetSummary:
        """How many robots are in which state, and those that need attention."""
        with self._lock:
            heard = {name: one for name, one in self._accounts.items() if one.heard}
            silent = {name: one for name, one in heard.items() if one.warned}
            busy = [one for one in heard.values() if not one.warned and one.status is Status.BUSY]
            return FleetSummary(
                tasks={name: one.count for name, one in self._accounts.items()},
                busy=len(busy),
                idle=len(heard) - len(silent) - len(busy),
                silent_s={name: now_s - one.last_seen_s for name, one in silent.items()},
                missing=[name for name in self._accounts if name not in heard],
            )

    def new_silences(self, *, now_s: float) -> list[Silence]:
        """Return the warnings that are due now, each once."""
        with self._lock:
            silences = []
            for robot_id, account in self._accounts.items():
                passed_s = self._pass_mark(account, now_s - account.last_seen_s)
                if passed_s is not None:
                    silences.append(Silence(robot_id=robot_id, silent_s=passed_s))
            return silences

    def _new_account(self, now_s: float) -> _Account:
        return _Account(last_seen_s=now_s, next_mark_s=self._silence_timeout_s)

    def _note_seen(self, robot_id: str, account: _Account, now_s: float) -> Arrival | None:
        first, warned = not account.heard, account.warned
        silent_s = now_s - account.last_seen_s
        account.heard, account.warned = True, False
        account.last_seen_s = now_s
        account.next_mark_s = self._silence_timeout_s
        if first:
            return Arrival(robot_id=robot_id)
        return Arrival(robot_id=robot_id, silent_s=silent_s) if warned else None

    def _pass_mark(self, account: _Account, silent_s: float) -> float | None:
        """Return the last mark that the silence has passed since the last call, or None."""
        passed_s = None
        while silent_s >= account.next_mark_s:
            passed_s = account.next_mark_s
            account.next_mark_s += min(passed_s, MAX_WARNING_GAP_S)
            account.warned = True
        return passed_s


def _count(account: _Account, status: RobotStatus) -> None:
    """Count completed tasks of the status that were not counted before."""
    if status.completed is None and status.task_id is None:
        _count_without_id(account, status)
        return
    done = list(status.completed or ())
    if status.status is Status.DONE and status.task_id is not None:
        done.append(status.task_id)
    for task_id in done:
        if task_id not in account.ids:
            account.ids[task_id] = None
            account.count += 1
    while len(account.ids) > REMEMBERED_IDS:
        del account.ids[next(iter(account.ids))]


def _count_without_id(account: _Account, status: RobotStatus) -> None:
    """Count a done of a sender with only the required fields, unless it repeats the last one."""
    if status.status is Status.BUSY:
        account.done_without_id = None
    elif status.task and status.task != account.done_without_id:
        account.done_without_id = status.task
        account.count += 1
