"""`action VERB ...`: list and inspect actions, and send goals."""

from __future__ import annotations

import contextlib
import functools
import signal
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode, UsageError
from launcher.base.model.ros_names import full_name
from launcher.base.option import JSON_LINES, option
from launcher.base.verb_table import VERBS
from launcher.posix.dispositions import Handled
from launcher.posix.json_output import print_line
from launcher.ros.verb import (
    GraphAccess,
    dispatch,
    graph_snapshot,
    observing,
    ros_command,
    seconds,
    show,
    show_typed,
    spin_time_s,
    standard_input,
    to_json_plain,
    warn,
)
from launcher.ros.verbs.listening import QOS, STYLE, qos_options, style

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer
    from launcher.ros.goals import Goal
    from launcher.ros.messages.from_yaml import Content
    from launcher.ros.service_caller import ServiceCaller
    from launcher.ros.snapshot.ros_graph import GraphSnapshot

_ANSWER_S = 30.0
_LATE = "Timed out waiting for result"

NAME = option("NAME", name="action_name")
TYPE = option("TYPE", name="action_type")
COUNT = option("-c, --count-actions", "print only their number")
SHOW_TYPES = option("-t, --show-types", "show their types")


def _list(options: Parsed) -> int:
    found = graph_snapshot(options).action_types()
    return show_typed(
        options,
        "actions",
        found,
        only_count=options.count_actions,
        with_types=options.show_types,
    )


def _info(options: Parsed) -> int:
    graph, name = graph_snapshot(options), full_name(options.action_name)
    users = {title: _users(graph, title, name) for title in ("Action Clients", "Action Servers")}
    if not any(users.values()) and (problem := _unknown(graph, name)):
        warn(f"hint: {problem}")
    document: dict[str, Any] = {"name": name}
    lines = [f"Action: {options.action_name}"]
    for title, nodes in users.items():
        lines.append(f"{title.capitalize()}: {len(nodes)}")
        document[title.split()[1].lower()] = [
            {"node": node, "types": types} for node, types in nodes
        ]
        for node, types in nodes if not options.count else ():
            shown = f" [{', '.join(types)}]" if options.show_types else ""
            lines.append(f"    {node}{shown}")
    return show(options, document, lines)


def _users(graph: GraphSnapshot, title: str, action: str) -> list[tuple[str, list[str]]]:
    """The nodes that use an action in this way, with the types that they give it."""
    return [
        (node, types)
        for node in sorted(set(graph.nodes))
        for name, types in graph.of_node(node)[title]
        if name == action
    ]


def _unknown(graph: GraphSnapshot, name: str) -> str | None:
    from launcher.base.ros_errors import did_you_mean

    known = graph.action_types()
    if not known:
        return "there are no actions" if graph.nodes else None
    return did_you_mean(name, known) or f"actions: {', '.join(known)}"


def _type(options: Parsed) -> int:
    from launcher.base.ros_errors import VerbError

    graph, name = graph_snapshot(options), full_name(options.action_name)
    types = graph.action_types().get(name)
    if types is None:
        raise VerbError(f"Unknown action '{options.action_name}'", hint=_unknown(graph, name))
    return show(options, {"name": name, "types": types}, types)


def _find(options: Parsed) -> int:
    from launcher.ros.messages.interfaces import of_type

    found = of_type(graph_snapshot(options).action_types(), options.action_type, "action")
    return show_typed(options, "actions", found, only_count=options.count_actions)


def _echo(options: Parsed) -> int:
    from launcher.ros.verbs.action_events import (
        ActionEchoOptions,
        InterfaceWriter,
        chosen_interfaces,
        echo,
    )

    return echo(
        ActionEchoOptions(
            access=GraphAccess.of(options),
            action=options.action_name,
            type=options.action_type,
            interfaces=chosen_interfaces(options.interfaces),
            writer=InterfaceWriter(style=style(options), csv=options.csv, json=options.json),
            qos=qos_options(options),
            timeout_s=options.timeout,
        )
    )


def _send_goal(options: Parsed) -> int:
    from launcher.ros.messages.from_yaml import Content, fill, parse
    from launcher.ros.messages.interfaces import load
    from launcher.ros.service_caller import ServiceCaller

    if options.goal and options.stdin:
        raise UsageError("YAML and --stdin exclude each other")
    kind = load(options.action_type, "action", "The passed action type is invalid")
    values = kind.Goal()
    stamps = fill(values, parse(standard_input() if options.stdin else options.goal))
    name = full_name(options.action_name)
    with (
        observing(GraphAccess.of(options), lambda graph: name in graph.action_types()) as observer,
        ServiceCaller(observer) as caller,
    ):
        caller.load(kind)
        _refuse_other_type(observer, name, kind, options)
        return _pursue(caller, kind, name, Content(values, stamps), options)


def _refuse_other_type(observer: Observer, name: str, kind: object, options: Parsed) -> None:
    """VerbError if the action has another type."""
    from launcher.base.ros_errors import VerbError
    from launcher.ros.discovery.completeness import settled_graph
    from launcher.ros.messages.classes import type_name

    graph = settled_graph(observer, spin_time_s(options), lambda g: name in g.action_types())
    types = graph.action_types().get(name, [])
    if types and type_name(kind) not in types:
        raise VerbError(
            f"action '{name}' has the type {', '.join(types)}, not {options.action_type}"
        )


def _pursue(
    caller: ServiceCaller, kind: object, name: str, content: Content, options: Parsed
) -> int:
    """Send the goal and wait for its end; cancel it on Ctrl-C, or if it takes too long."""
    from launcher.ros.goals import Goal
    from launcher.ros.service_caller import NoAnswerError

    def feedback(message: Any) -> None:
        _show(
            options,
            {"event": "feedback", "feedback": message},
            f"Feedback:\n    {_yaml(message, options)}",
        )

    goal = Goal(caller, kind, name, feedback if options.feedback else None)
    limit_s = options.timeout or None
    _show(options, None, "Waiting for an action server to become available...")
    if not goal.wait_for_server(limit_s):
        raise NoAnswerError(f"Action server is not available after waiting {limit_s:g} seconds.")
    content.stamp(time.time_ns())
    _show(options, None, f"Sending goal:\n     {_yaml(content.message, options)}")
    try:
        with _interrupts() as goal.interrupts:
            accepted = goal.send(content.message, limit_s or _ANSWER_S)
            document = {"event": "accepted" if accepted else "rejected", "goal_id": goal.id}
            if not accepted:
                _show(options, document, "Goal was rejected.")
                return ExitCode.PROCESS_FAILED
            _show(options, document, f"Goal accepted with ID: {goal.id}\n")
            if options.timeout == 0:
                _show(options, None, f"{_LATE} after 0 seconds.")  # the words of ros2cli
                warn("hint: the goal goes on; -t 0 does not wait for its end")
                return ExitCode.OK
            found = goal.result(limit_s)
    except KeyboardInterrupt:
        _cancel(goal, options)
        return ExitCode.INTERRUPTED
    if found is None:
        warn(f"{_LATE} after {limit_s:g} seconds.")
        _cancel(goal, options)
        return ExitCode.PROCESS_FAILED
    return _ended(*found, options)


def _ended(status: str, result: Any, options: Parsed) -> int:
    text = f"Result:\n    {_yaml(result, options)}\nGoal finished with status: {status}"
    _show(options, {"event": "ended", "status": status, "result": result}, text)
    return ExitCode.OK if status == "SUCCEEDED" else ExitCode.PROCESS_FAILED


@contextlib.contextmanager
def _interrupts() -> Iterator[list[int]]:
    """Collect signals that ask for an end, which may not raise anywhere within rclpy."""
    seen: list[int] = []
    signums = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    with Handled(lambda number, _: seen.append(number), signums):
        yield seen


def _cancel(goal: Goal, options: Parsed) -> None:
    _show(options, None, "Canceling goal...")
    goal.cancel()
    _show(options, {"event": "canceled", "goal_id": goal.id}, "Goal canceled.")


def _yaml(message: Any, options: Parsed) -> str:
    from launcher.ros.messages.to_yaml import to_yaml

    return "" if options.json else to_yaml(message)


def _show(options: Parsed, document: dict[str, Any] | None, text: str) -> None:
    """Print the text, or with --json a line of the document, if there is one."""
    from launcher.ros.messages.to_yaml import to_plain

    if not options.json:
        print(text, flush=True)
    elif document is not None:
        plain = {
            name: to_json_plain(to_plain(value)) if hasattr(value, "SLOT_TYPES") else value
            for name, value in document.items()
        }
        print_line(plain)


COMMAND = Command(
    "action",
    VERBS["action"],
    commands=(
        ros_command("action list", "list actions", _list, SHOW_TYPES, COUNT),
        ros_command(
            "action info",
            "show the clients and servers of an action",
            _info,
            NAME,
            SHOW_TYPES,
            option("-c, --count", "print only how many there are"),
        ),
        ros_command("action type", "print the type of an action", _type, NAME),
        ros_command("action find", "list the actions of a type", _find, TYPE, COUNT),
        ros_command(
            "action echo",
            "print the feedback, the states of goals and the events of services of an action",
            _echo,
            NAME,
            option("[TYPE]", name="action_type"),
            option(
                "-i, --interfaces LIST",
                "of GOAL_SERVICE|CANCEL_SERVICE|RESULT_SERVICE|FEEDBACK_TOPIC|STATUS_TOPIC "
                "(default: all)",
            ),
            option("--timeout S", "end after S seconds", seconds),
            *STYLE,
            groups=QOS,
            json=JSON_LINES,
        ),
        ros_command(
            "action send_goal",
            "send a goal, and wait for its result; Ctrl-C cancels it",
            _send_goal,
            NAME,
            TYPE,
            option("[YAML]", "the goal", default="", name="goal"),
            option("--stdin", "read the YAML from stdin"),
            option("-f, --feedback", "print the feedback"),
            option(
                "-t, --timeout S",
                "wait S seconds for the server, and as long for its answer and for the end of the "
                "goal, which is then cancelled; 0: do not wait for the end (default: 30 for the "
                "answer, else without end)",
                seconds,
            ),
            json=JSON_LINES,
        ),
    ),
)

main = functools.partial(dispatch, COMMAND)
