"""
The queue overflow experiment: how many tasks the slow robot loses at which rate and depth.

    python -m group_gp1.queue_overflow
    python -m group_gp1.queue_overflow --case 6:1 --seconds 10

Each case is a dispatch rate and a queue depth. It runs the real dispatcher and the real robot_2
as processes in a domain of their own, subscribes to both topics, stops the dispatcher, waits until
robot_2 has finished its queue, and compares assigned with completed tasks.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
import contextlib
from dataclasses import dataclass
import os
import signal
import subprocess
import sys
import time

from group_gp1 import qos, topics
from group_gp1.logic.messages import RobotStatus, Status, TaskAssignment
from launcher.posix.domain_lease import leased_domain
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String

ROBOT = 'robot_2'
IDLE_REPORTS = 3  # between two queued tasks a robot repeats its done at most once
START_TIMEOUT_S = 60.0  # importing rclpy on a busy machine takes long
DRAIN_TIMEOUT_S = 120.0
STOP_TIMEOUT_S = 10.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One dispatch rate, to all robots together, and one depth of robot_2's queue."""

    rate_hz: float
    depth: int

    @classmethod
    def parse(cls, text: str) -> Case:
        """Read `RATE:DEPTH`; raises ValueError."""
        rate, depth = text.split(':')
        return cls(rate_hz=float(rate), depth=int(depth))


DEFAULT_CASES = tuple(map(Case.parse, ('1:5', '3:5', '3:3', '3:1', '3:20', '6:5', '6:1')))


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """Tasks assigned to and executed by robot_2, from the first one that it completed."""

    case: Case
    assigned: int
    executed: int

    @property
    def lost(self) -> int:
        return self.assigned - self.executed


class Witness(Node):
    """Subscribes to the fleet and records the task ids of robot_2, in order."""

    def __init__(self, context: Context) -> None:
        super().__init__('overflow_witness', context=context)
        self.assigned: list[str] = []
        self.executed: set[str] = set()
        self.heard_robot = False
        self.idle_reports = 0
        self._last_done: str | None = None
        profile = qos.tasks_profile(qos.MAX_DEPTH)  # the witness itself must not lose messages
        self.create_subscription(String, topics.TASKS, self._note_assignment, profile)
        self.create_subscription(String, topics.STATUS, self._note_status, qos.STATUS)

    def _note_assignment(self, message: String) -> None:
        assignment = TaskAssignment.from_json(message.data)
        if assignment.robot_id == ROBOT and assignment.task_id is not None:
            self.assigned.append(assignment.task_id)

    def _note_status(self, message: String) -> None:
        status = RobotStatus.from_json(message.data)
        self.heard_robot = True
        self.executed.update(status.completed or ())
        repeated = status.status is Status.DONE and status.task_id == self._last_done
        self.idle_reports = self.idle_reports + 1 if repeated else 0
        self._last_done = status.task_id if status.status is Status.DONE else None

    def result(self, case: Case) -> Result:
        """Count so far, without tasks that were sent before robot_2 was connected."""
        done = [task_id in self.executed for task_id in self.assigned]
        first = done.index(True) if any(done) else 0
        counted = done[first:]
        return Result(case=case, assigned=len(counted), executed=sum(counted))


def measure(case: Case, *, seconds: float, domain_id: int) -> Result:
    """Run one case; the dispatcher sends for `seconds` once robot_2 has completed a task."""
    with contextlib.ExitStack() as stack:
        witness, wait_until = stack.enter_context(_witness(domain_id))
        stack.enter_context(_node(ROBOT, domain_id, {'task_queue_depth': case.depth}))
        wait_until(lambda: witness.heard_robot, START_TIMEOUT_S)
        settings = {'dispatch_rate_hz': case.rate_hz, 'task_history_depth': qos.MAX_DEPTH}
        with _node('dispatcher', domain_id, settings):
            wait_until(lambda: bool(witness.executed), START_TIMEOUT_S)
            end_s = time.monotonic() + seconds
            wait_until(lambda: time.monotonic() >= end_s, seconds + 1.0)
        wait_until(lambda: witness.idle_reports >= IDLE_REPORTS, DRAIN_TIMEOUT_S)
        return witness.result(case)


@contextlib.contextmanager
def _witness(
    domain_id: int,
) -> Iterator[tuple[Witness, Callable[[Callable[[], bool], float], None]]]:
    context = Context()
    rclpy.init(context=context, domain_id=domain_id)
    witness = Witness(context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(witness)

    def wait_until(fact: Callable[[], bool], timeout_s: float) -> None:
        deadline_s = time.monotonic() + timeout_s
        while not fact():
            if time.monotonic() > deadline_s:
                raise SystemExit(f'error: no progress of the fleet within {timeout_s:g} s')
            executor.spin_once(timeout_sec=0.1)

    try:
        yield witness, wait_until
    finally:
        executor.shutdown()
        witness.destroy_node()
        context.try_shutdown()


@contextlib.contextmanager
def _node(name: str, domain_id: int, settings: dict[str, float]) -> Iterator[None]:
    command = [sys.executable, '-m', f'group_gp1.{name}', '--ros-args', '--log-level', 'warn']
    for key, value in settings.items():
        command += ['-p', f'{key}:={value}']
    process = subprocess.Popen(command, env={**os.environ, 'ROS_DOMAIN_ID': str(domain_id)})
    try:
        yield
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(STOP_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def row(result: Result) -> str:
    share = 100.0 * result.lost / result.assigned if result.assigned else 0.0
    return (
        f'| {result.case.rate_hz:>7g} | {result.case.depth:>5} | {result.assigned:>8} '
        f'| {result.executed:>8} | {result.lost:>4} | {share:>4.0f} % |'
    )


def main(args: list[str] | None = None) -> None:
    """Measure the cases and print the table."""
    parser = argparse.ArgumentParser(prog='python -m group_gp1.queue_overflow')
    parser.add_argument(
        '--case',
        dest='cases',
        action='append',
        type=Case.parse,
        metavar='RATE:DEPTH',
        help='dispatch rate in Hz and depth of the queue; may be given several times',
    )
    parser.add_argument('--seconds', type=float, default=20.0, help='length of one case')
    options = parser.parse_args(args)
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    print('| rate Hz | depth | assigned | executed | lost |  share |')
    print('|--------:|------:|---------:|---------:|-----:|-------:|')
    with contextlib.suppress(KeyboardInterrupt), leased_domain() as domain_id:
        for case in options.cases or DEFAULT_CASES:
            result = measure(case, seconds=options.seconds, domain_id=domain_id)
            print(row(result), flush=True)


if __name__ == '__main__':
    main()
