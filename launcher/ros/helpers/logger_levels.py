"""Reads and sets the levels of loggers in running nodes, as a separate process.

A list of questions on standard input, as JSON in one line; the list of answers on standard output.
A node is asked by the services that it has with `enable_logger_service=True`. It ends with its
answer, after a time limit, or with its input.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from typing import TYPE_CHECKING, Any

from launcher.base import strict_json
from launcher.posix import dispositions
from launcher.posix.stdio import keep_for_messages

if TYPE_CHECKING:
    from launcher.ros.service_caller import ServiceCaller

LEVELS = {0: "UNSET", 10: "DEBUG", 20: "INFO", 30: "WARN", 40: "ERROR", 50: "FATAL"}
FIND_S = 8.0  # for a node to be discovered
NO_SERVICE_S = 1.0  # after a node was discovered, its services and the next node have been, too
PERIOD_S = 0.05

Question = dict[str, Any]
Answer = dict[str, Any]


def answers(caller: ServiceCaller, questions: list[Question]) -> list[Answer]:
    """One for each node, in order of the questions."""
    deadline_s = time.monotonic() + FIND_S
    return [
        _answer(caller, {**question, "node": node}, deadline_s)
        for question in questions
        for node in _nodes(caller, question, deadline_s)
    ]


def _nodes(caller: ServiceCaller, question: Question, deadline_s: float) -> list[str | None]:
    """The node, or those of the process; [None] if there is none."""
    if question["node"] is not None or question["pid"] is None:
        return [question["node"]]
    from launcher.ros.node_tables import owners

    until_s = deadline_s
    while True:
        pid = question["pid"]
        nodes = list(owners(caller, hidden=False))
        found = [one.node for one in nodes if _owns(pid, one.pid)]
        if found:  # others that are not discovered may be of this process, too
            until_s = min(until_s, time.monotonic() + NO_SERVICE_S)
        is_whole = bool(found) and not any(one.undiscovered for one in nodes)
        if is_whole or time.monotonic() > until_s:
            return list(found) or [None]
        time.sleep(PERIOD_S)


def _owns(session: int, pid: int | None) -> bool:
    """Whether this is the process, or in its session."""
    try:
        return pid is not None and session in (pid, os.getsid(pid))
    except OSError:
        return False


def _answer(caller: ServiceCaller, question: Question, deadline_s: float) -> Answer:
    from launcher.base.ros_errors import VerbError

    node = question["node"]
    answer = {"process": question["process"], "node": node, "error": None}
    answer["error"] = problem = _missing(caller, node, deadline_s)
    if problem is not None:
        return answer
    # As rcl derives it from the name.
    answer["logger"] = logger = question["logger"] or node.strip("/").replace("/", ".")
    try:
        if question["level"] is not None:
            answer["error"] = _set(caller, node, logger, question["level"])
        answer["level"], answer["source"] = _get(caller, node, logger)
    except VerbError as error:
        answer["error"] = f"{node}: {error.message}"
    return answer


def _missing(caller: ServiceCaller, node: str | None, deadline_s: float) -> str | None:
    """Why the node cannot be asked; None if it can."""
    if node is None:
        return "its node was not found in the graph"
    seen_s = None
    while time.monotonic() < deadline_s:
        services = dict(caller.observer.node.get_service_names_and_types())
        if {f"{node}/get_logger_levels", f"{node}/set_logger_levels"} <= services.keys():
            return None
        if seen_s is None and node in caller.observer.node_names():
            seen_s = time.monotonic()
        if seen_s is not None and time.monotonic() - seen_s > NO_SERVICE_S:
            return (
                f"{node} does not offer to set its levels; a node does with "
                "enable_logger_service=True in its constructor"
            )
        time.sleep(PERIOD_S)
    if seen_s is None:
        return f"{node} was not found in the graph"
    return f"{node} does not offer to set its levels"


def _set(caller: ServiceCaller, node: str, logger: str, level: str) -> str | None:
    from rcl_interfaces.msg import LoggerLevel
    from rcl_interfaces.srv import SetLoggerLevels

    number = next(number for number, name in LEVELS.items() if name == level)
    request = SetLoggerLevels.Request(levels=[LoggerLevel(name=logger, level=number)])
    results = caller.ask(SetLoggerLevels, f"{node}/set_logger_levels", request).results
    if not results:
        return f"{node} has not answered for it"
    reason = results[0].reason or "no reason"
    return None if results[0].successful else f"{node} refused it: {reason}"


def _get(caller: ServiceCaller, node: str, logger: str) -> tuple[str, str]:
    """The level that counts, and the logger that it is from: its own, a parent or the root."""
    from rcl_interfaces.srv import GetLoggerLevels

    parts = logger.split(".")
    names = [".".join(parts[:size]) for size in range(len(parts), 0, -1)]
    request = GetLoggerLevels.Request(names=[*names, ""])
    found = caller.ask(GetLoggerLevels, f"{node}/get_logger_levels", request).levels
    for one in found:
        if one.level:
            return LEVELS.get(one.level, str(one.level)), one.name
    return LEVELS[0], ""


def main() -> None:
    keep_for_messages()
    dispositions.ignore()  # we end with our input
    questions = strict_json.unpacked(sys.stdin.readline())
    threading.Thread(target=_await_end_of_input, daemon=True).start()
    from launcher.ros.discovery.observer import Observer
    from launcher.ros.service_caller import ServiceCaller

    with Observer(purpose="logger levels") as observer, ServiceCaller(observer) as caller:
        print(strict_json.packed(answers(caller, questions)), flush=True)


def _await_end_of_input() -> None:
    os.read(0, 1)
    os._exit(1)  # what it may leave of shared memory, the launcher frees


if __name__ == "__main__":
    main()
