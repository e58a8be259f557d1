"""The mutants of the fleet: one small change of its sources each."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

SYSTEM, STALL, WAREHOUSE = "system", "stall", "warehouse"
SMOKE_FILES = (SYSTEM, STALL, WAREHOUSE)


class MutationError(Exception):
    """A mutant does not fit the sources; the text names it."""


@dataclass(frozen=True, slots=True)
class Mutant:
    """In `file` of `group_gp1`, `old`, which occurs once, becomes `new`.

    `smoke_file` is tried first.
    """

    name: str
    file: str
    old: str
    new: str
    smoke_file: str = SYSTEM

    def mutated(self, package: Path) -> str:
        """The changed text of the file; MutationError."""
        text = (package / self.file).read_text(encoding="utf-8")
        if text.count(self.old) != 1:
            times = text.count(self.old)
            raise MutationError(f"{self.name}: {self.file} has {times} times: {self.old}")
        return text.replace(self.old, self.new)


MUTANTS = (
    # ---- the dispatcher
    Mutant(
        "task-ids-equal",
        "logic/rotation.py",
        "task_id=f'{self._run}-{next(self._numbers)}'",
        "task_id=f'{self._run}-1'",
    ),
    Mutant("task-rate", "nodes/dispatcher_node.py", "1.0 / rate_hz", "0.8 / rate_hz"),
    Mutant(
        "task-order",
        "logic/rotation.py",
        "itertools.cycle(robot_ids)",
        "itertools.cycle(reversed(robot_ids))",
    ),
    Mutant(
        "task-missing",
        "logic/messages.py",
        "fields = {'robot_id': self.robot_id, 'task': self.task}",
        "fields = {'robot_id': self.robot_id}",
    ),
    Mutant(
        "task-twice",
        "nodes/dispatcher_node.py",
        "        self._tasks.publish(String(data=assignment.to_json()))\n",
        "        for _ in range(2):\n"
        "            self._tasks.publish(String(data=assignment.to_json()))\n",
    ),
    # ---- the robots
    Mutant(
        "status-twice",
        "nodes/robot_node.py",
        "        self._statuses.publish(String(data=status.to_json()))\n",
        "        for _ in range(2):\n"
        "            self._statuses.publish(String(data=status.to_json()))\n",
    ),
    Mutant(
        "status-not-repeated",
        "nodes/robot_node.py",
        "        self._publish(self._work.status)\n",
        "        pass\n",
    ),
    Mutant(
        "status-without-task",
        "logic/messages.py",
        "            'task': self.task,\n        }",
        "        }",
    ),
    Mutant("robot-ids-swapped", "robot_1.py", "robot_id='robot_1'", "robot_id='robot_2'"),
    Mutant(
        "works-for-others",
        "nodes/robot_node.py",
        "if assignment.robot_id == self._robot_id:",
        "if assignment.robot_id:",
    ),
    Mutant(
        "late-joiner-gets-nothing",
        "nodes/robot_node.py",
        "qos.tasks_profile(self._declare_queue_depth())",
        "qos.status_profile(self._declare_queue_depth())",
    ),
    Mutant(
        "exit-code",
        "robot_2.py",
        "        runner.run(lambda: Robot(PROFILE), args)\n",
        "        runner.run(lambda: Robot(PROFILE), args)\n        raise SystemExit(3)\n",
    ),
    # ---- the monitor
    Mutant(
        "counts-double",
        "logic/bookkeeping.py",
        "            account.ids[task_id] = None\n            account.count += 1\n",
        "            account.ids[task_id] = None\n            account.count += 2\n",
    ),
    Mutant(
        "counts-repeats",
        "logic/bookkeeping.py",
        "        if task_id not in account.ids:\n",
        "        if task_id:\n",
    ),
    Mutant(
        "never-warns",
        "nodes/monitor_node.py",
        "self.get_logger().warn(str(silence))",
        "pass",
        STALL,
    ),
    Mutant(
        "warning-level",
        "nodes/monitor_node.py",
        "self.get_logger().warn(str(silence))",
        "self.get_logger().info(str(silence))",
        STALL,
    ),
    Mutant(
        "silence-timeout-ignored",
        "logic/bookkeeping.py",
        "        account.next_mark_s = self._silence_timeout_s\n",
        "        account.next_mark_s = 9.0\n",
        STALL,
    ),
    Mutant(
        "recovery-repeated",
        "logic/bookkeeping.py",
        "account.heard, account.warned = True, False",
        "account.heard = True",
        STALL,
    ),
    Mutant(
        "report-rate", "nodes/monitor_node.py", "REPORT_PERIOD_S = 2.0", "REPORT_PERIOD_S = 3.0"
    ),
    Mutant("report-text", "logic/messages.py", "Fleet report -- ", "Report of the fleet -- "),
    Mutant(
        "memory",
        "nodes/monitor_node.py",
        "        self._books = self._open_books()\n",
        '        self._books = self._open_books()\n        self._ballast = b"x" * (200 << 20)\n',
    ),
    # ---- quality of service
    Mutant("status-depth", "qos.py", "STATUS_DEPTH = 3\n", "STATUS_DEPTH = 1\n"),
    Mutant("backlog-of-two", "qos.py", "TASKS_DEPTH = 5\n", "TASKS_DEPTH = 2\n"),
    Mutant(
        "tasks-volatile",
        "qos.py",
        "durability=DurabilityPolicy.TRANSIENT_LOCAL",
        "durability=DurabilityPolicy.VOLATILE",
    ),
    Mutant(
        "status-reliable",
        "qos.py",
        "reliability=ReliabilityPolicy.BEST_EFFORT",
        "reliability=ReliabilityPolicy.RELIABLE",
    ),
    Mutant(
        "probe-matches",
        "nodes/qos_probe_node.py",
        "            qos.RELIABLE_STATUS,\n            event",
        "            qos.STATUS,\n            event",
    ),
    # ---- the debug logger
    Mutant(
        "debug-logger-silent",
        "nodes/debug_logger_node.py",
        "get_logger().info(",
        "get_logger().debug(",
    ),
)
