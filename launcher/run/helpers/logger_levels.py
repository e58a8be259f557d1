"""Starts `launcher.ros.helpers.logger_levels`, which asks nodes for the levels of their loggers.

One for each request and domain; it ends with its answer, with its time limit, or with the run.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Sequence

from launcher.base import strict_json
from launcher.base.model.record import Record
from launcher.posix import spawn
from launcher.posix.cleanup import RUN_ID_VARIABLE
from launcher.run.helpers.popen import start_module
from launcher.run.helpers.programs import LOGGER_LEVELS
from launcher.run.part import Part
from launcher.run.process import Process

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.run.run import Run

Answers = list[dict[str, "Any"]]


class LoggerQuestion(Record):
    """A node, or all of the process (None), whose logger is asked for, or set to `level`.

    Without a `logger` it is that of the node.
    """

    process: Process
    node: str | None
    logger: str | None = None
    level: str | None = None


class LoggerLevels(Part):
    """The helpers that are running."""

    def __init__(self, run: Run) -> None:
        super().__init__(run)
        self._reactor = run.reactor
        self._helpers: dict[int, subprocess.Popen[bytes]] = {}

    def ask(self, questions: Sequence[LoggerQuestion], done: Callable[[Answers], None]) -> None:
        """Call `done` with an answer for each node: process, node, logger, level, error."""
        domains: dict[str, list[LoggerQuestion]] = {}
        for one in questions:
            domains.setdefault(one.process.spec.env.get("ROS_DOMAIN_ID") or "0", []).append(one)
        answers: Answers = []
        waiting = len(domains)

        def add(some: Answers) -> None:
            nonlocal waiting
            answers.extend(some)
            waiting -= 1
            if not waiting:
                done(answers)

        for group in domains.values():
            self._start(group, add)

    def _start(self, questions: Sequence[LoggerQuestion], done: Callable[[Answers], None]) -> None:
        env = {**questions[0].process.spec.env}
        env.pop(RUN_ID_VARIABLE, None)
        env.setdefault("FASTDDS_BUILTIN_TRANSPORTS", "UDPv4")  # as for `graph_facts`
        helper = start_module(
            [LOGGER_LEVELS],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=env,
            bufsize=0,
        )
        spawn.started.add(helper.pid)
        assert helper.stdin is not None and helper.stdout is not None
        request = strict_json.packed([_as_json(one) for one in questions])
        helper.stdin.write(request.encode() + b"\n")
        fd = helper.stdout.fileno()
        self._helpers[fd] = helper
        received = b""

        def read() -> None:
            nonlocal received
            chunk = os.read(fd, 65536)
            was_complete = b"\n" in received
            received += chunk
            if not chunk:
                self._end(fd)
            if not was_complete and (not chunk or b"\n" in chunk):
                done(_answers(received, questions))  # its clean-up takes longer

        self._reactor.add_reader(fd, read)

    def _end(self, fd: int) -> None:
        helper = self._helpers.pop(fd)
        self._reactor.remove(fd)
        assert helper.stdin is not None and helper.stdout is not None
        helper.stdin.close()
        helper.stdout.close()
        helper.kill()  # if it hangs in its clean-up
        helper.wait()
        spawn.started.discard(helper.pid)

    def end_helpers(self) -> None:
        """Nobody waits for the answers."""
        for fd in tuple(self._helpers):
            self._end(fd)


def _as_json(one: LoggerQuestion) -> dict[str, Any]:
    child = one.process.child
    return {
        "process": one.process.name,
        "pid": child.pid if child is not None and one.process.host is None else None,
        "node": one.node,
        "logger": one.logger,
        "level": one.level,
    }


def _answers(text: bytes, questions: Sequence[LoggerQuestion]) -> Answers:
    try:
        found: Answers = strict_json.unpacked(text)
    except ValueError:
        error = "cannot be asked: rclpy cannot be used in its environment"
        return [
            {"process": one.process.name, "node": one.node, "error": error} for one in questions
        ]
    return found
