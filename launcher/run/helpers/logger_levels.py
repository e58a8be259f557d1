"""Starts `launcher.ros.helpers.logger_levels`, which asks nodes for the levels of their loggers.

One for each request and domain; it ends with its answer, with its time limit, or with the run.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence

from launcher.base.model.record import Record
from launcher.base.program import program
from launcher.base.run_verb import BadCallError
from launcher.base.text import did_you_mean
from launcher.output.filters import LEVELS
from launcher.run.helpers.helper_programs import LOGGER_LEVELS
from launcher.run.helpers.json_lines import JsonLinesProcess, own_end, without_shared_memory
from launcher.run.part import Part
from launcher.run.processes.process import Process
from launcher.run.requests.process_selection import ProcessNames, parts_meant

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from launcher.run.part import Exchange, VerbRequest
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


# ---- the verb


def serve(request: VerbRequest) -> None:
    """Ask the nodes of the processes, and answer when they have; BadCallError."""
    call = request.call
    word = call.options.get("level")
    level = None if word is None else _level(word)
    ask = functools.partial(LoggerQuestion, logger=call.options.get("logger"), level=level)
    refusals, questions = [], []
    labels: dict[tuple[str, str | None], str] = {}
    for process in request.chosen():
        refusal = _refusal(process)
        if refusal:
            refusals.append({"process": process.name, "node": None, "error": refusal})
        for spec in () if refusal else parts_meant(call.names, process.spec):
            nodes = ProcessNames.of(spec).nodes or (None,)
            questions += [ask(process=process, node=node) for node in nodes]
            labels.update(
                ((process.name, n), n.rpartition("/")[2] if n else spec.label) for n in nodes
            )

    def done(answers: Answers) -> None:
        _reply(request.exchange, [*refusals, *answers], labels, has_set=level is not None)

    if questions:
        request.run.parts.need(LoggerLevels).ask(questions, done)
    else:
        done([])


def _level(word: str) -> str:
    upper = "WARN" if word.upper() == "WARNING" else word.upper()
    if upper in LEVELS:
        return upper
    known = ", ".join(LEVELS)
    hint = did_you_mean(upper, LEVELS) or f"known: {known}; `level` hides lines on the screen"
    raise BadCallError("bad-option", f"unknown level '{word}'", hint)


def _refusal(process: Process) -> str:
    """Why its nodes are not asked; empty if they are."""
    ros, members = process.spec.ros, process.spec.members
    if ros is None and not members:
        return "is not started as a ROS node"
    if process.child is None:
        return f"is not running ({process.machine.state.value})"
    if process.host is not None and ros is not None and ros.node_name is None:
        return f"is on {process.host_name}, and the launch file does not name its node"
    return ""


def _reply(
    exchange: Exchange,
    answers: Answers,
    labels: Mapping[tuple[str, str | None], str],
    *,
    has_set: bool,
) -> None:
    """`labels`: what --log-level calls the nodes that were asked, by process and node."""
    text = [_sentence(one, has_set=has_set) for one in answers]
    if not all(one["error"] for one in answers):
        exchange.reply({"levels": answers}, text)
        return
    hint = None
    one = next((one for one in answers if "enable_logger_service" in one["error"]), None)
    if one is not None:
        own = one["process"].rpartition("-")[0]
        unnamed = labels.get((one["process"], None), own)
        label = labels.get((one["process"], one["node"]), unnamed)
        hint = f"or from its start: {program()} launch ... --log-level {label}=debug"
    exchange.fail(BadCallError("wrong-state", "; ".join(text), hint))


def _sentence(answer: Mapping[str, Any], *, has_set: bool) -> str:
    """`robot_1-2: logger robot_1 is now at DEBUG`."""
    name = answer["process"]
    if answer["error"]:
        verb = "" if answer["error"].startswith("is ") else ":"
        return f"{name}{verb} {answer['error']}"
    logger, level, source = answer["logger"], answer["level"], answer["source"]
    of = "" if source == logger else " (from its process)"
    if source and source != logger:
        of = f" (from {source})"
    return f"{name}: logger {logger} is {'now ' if has_set else ''}at {level}{of}"
