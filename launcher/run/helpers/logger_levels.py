"""Starts `launcher.ros.helpers.logger_levels`, which asks nodes for the levels of their loggers.

One for each request and domain; it ends with its answer, with its time limit, or with the run.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from launcher.base.model.record import Record
from launcher.run.helpers.json_lines import JsonLinesProcess, own_end, without_shared_memory
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
        self._helpers: list[JsonLinesProcess] = []

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
        is_answered = False

        def answered(answers: Answers) -> None:
            nonlocal is_answered
            if not is_answered:  # its clean-up takes longer
                is_answered = True
                done(answers)

        def ended(code: int, line: str) -> None:
            self._helpers.remove(helper)
            answered(_without_answer(questions))

        env = without_shared_memory(own_end(questions[0].process.spec.env))
        helper = JsonLinesProcess(
            self._reactor, LOGGER_LEVELS, env, on_message=answered, on_end=ended
        )
        helper.send([_as_json(one) for one in questions])
        self._helpers.append(helper)

    def end_helpers(self) -> None:
        """Nobody waits for the answers."""
        for helper in self._helpers:
            helper.close()
        self._helpers.clear()


def _as_json(one: LoggerQuestion) -> dict[str, Any]:
    child = one.process.child
    return {
        "process": one.process.name,
        "pid": child.pid if child is not None and one.process.host is None else None,
        "node": one.node,
        "logger": one.logger,
        "level": one.level,
    }


def _without_answer(questions: Sequence[LoggerQuestion]) -> Answers:
    error = "cannot be asked: rclpy cannot be used in its environment"
    return [{"process": one.process.name, "node": one.node, "error": error} for one in questions]
