"""`lifecycle VERB ...`: list lifecycle nodes, show and change their state."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode
from launcher.base.model.ros_names import full_name
from launcher.base.option import option
from launcher.base.verb_table import VERBS
from launcher.ros.verb import (
    GraphAccess,
    dispatch,
    graph_snapshot,
    observing,
    ros_command,
    seconds,
    settled_observer,
    show,
    show_lines,
    spin_time_s,
    warn,
)

if TYPE_CHECKING:
    from launcher.ros.service_caller import ServiceCaller

NODE = option("NODE", name="node_name")
HIDDEN = option("--include-hidden-nodes", "ignored: a node that is named may be hidden")
TIMEOUT = option("--timeout S", "wait S seconds for an answer of a node (default: 5)", seconds)


def _nodes(options: Parsed) -> int:
    from launcher.ros.node_tables import visible_names

    graph = graph_snapshot(options)
    found = visible_names(graph.lifecycle_nodes(), hidden=options.include_hidden_nodes)
    lines = [len(found)] if options.count_nodes else found
    return show(options, {"nodes": [{"name": name} for name in found]}, lines)


@contextlib.contextmanager
def _asking(options: Parsed) -> Iterator[tuple[ServiceCaller, str]]:
    """A caller, and the full name of the lifecycle node that the options name."""
    from launcher.ros.service_caller import ServiceCaller

    node = full_name(options.node_name)
    with (
        observing(GraphAccess.of(options), lambda graph: graph.is_lifecycle(node)) as observer,
        ServiceCaller(observer, answer_s=options.timeout) as caller,
    ):
        from launcher.ros import lifecycle_nodes

        lifecycle_nodes.prepare(caller, node)
        yield caller, lifecycle_nodes.require(observer, node, spin_time_s(options))


def _list(options: Parsed) -> int:
    from launcher.ros import lifecycle_nodes

    with _asking(options) as (caller, node):
        found = lifecycle_nodes.transitions(caller, node, every=options.all)
    document = [
        {
            **_document(one.transition),
            "start": one.start_state.label,
            "goal": one.goal_state.label,
        }
        for one in found
    ]
    lines = (
        f"- {one['label']} [{one['id']}]\n\tStart: {one['start']}\n\tGoal: {one['goal']}"
        for one in document
    )
    return show(options, {"node": node, "transitions": document}, lines)


def _document(labelled: Any) -> dict[str, Any]:
    """Of a state or a transition."""
    return {"id": labelled.id, "label": labelled.label}


def _get(options: Parsed) -> int:
    if options.node_name is None:
        return _get_all(options)
    from launcher.ros import lifecycle_nodes

    with _asking(options) as (caller, node):
        found = dict(_states(caller, [node], options))
        if not found[node]:
            raise lifecycle_nodes.silence_of(node, caller.answer_s)
    return show(options, _states_document(found), _state_lines(found[node]))


def _get_all(options: Parsed) -> int:
    from launcher.ros import lifecycle_nodes
    from launcher.ros.node_tables import visible_names
    from launcher.ros.service_caller import ServiceCaller

    found: dict[str, dict[str, Any]] = {}
    code = ExitCode.OK
    with (
        settled_observer(options) as observer,
        ServiceCaller(observer, answer_s=options.timeout) as caller,
    ):
        every = observer.graph_snapshot().lifecycle_nodes()
        names = visible_names(every, hidden=options.include_hidden_nodes)
        for node, entry in _states(caller, names, options):
            if not entry:
                problem = lifecycle_nodes.silence_of(node, caller.answer_s).message
                warn(f"Exception while calling service of node '{node}': {problem}")
                code = ExitCode.PROCESS_FAILED
                continue
            found[node] = entry
            show_lines(options, _state_lines(entry, f"{node}: "))
    show(options, _states_document(found), ())
    return code


def _states(
    caller: ServiceCaller, names: list[str], options: Parsed
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Each node and what is known of its state, which is nothing if it does not answer."""
    from launcher.ros import lifecycle_nodes

    for node, state in lifecycle_nodes.states(caller, names):
        entry: dict[str, Any] = {} if state is None else {"state": _document(state)}
        if entry and options.transitions:
            possible = lifecycle_nodes.transitions(caller, node)
            entry["transitions"] = [_document(one.transition) for one in possible]
        yield node, entry


def _states_document(found: dict[str, dict[str, Any]]) -> dict[str, Any]:
    return {"nodes": [{"name": node, **entry} for node, entry in found.items()]}


def _state_lines(entry: dict[str, Any], prefix: str = "") -> Iterator[str]:
    yield f"{prefix}{entry['state']['label']} [{entry['state']['id']}]"
    for one in entry.get("transitions", ()):
        yield f"- {one['label']} [{one['id']}]"


def _set(options: Parsed) -> int:
    from launcher.ros import lifecycle_nodes

    with _asking(options) as (caller, node):
        transition = lifecycle_nodes.find(
            lifecycle_nodes.transitions(caller, node), options.transition
        )
        lifecycle_nodes.change(caller, node, transition, options.timeout)
    document = {"node": node, "transition": _document(transition), "done": True}
    return show(options, document, ["Transitioning successful"])


COMMAND = Command(
    "lifecycle",
    VERBS["lifecycle"],
    commands=(
        ros_command(
            "lifecycle nodes",
            "list the nodes that have a lifecycle",
            _nodes,
            option("-a, --all, --include-hidden-nodes", "hidden nodes as well"),
            option("-c, --count-nodes", "print only the number of nodes"),
        ),
        ros_command(
            "lifecycle list",
            "list the transitions that a node can make now",
            _list,
            NODE,
            option("-a, --all", "all transitions that it has, from whichever state"),
            HIDDEN,
            TIMEOUT,
        ),
        ros_command(
            "lifecycle get",
            "print the state of a node, or of all lifecycle nodes",
            _get,
            option("[NODE]", name="node_name"),
            option("-a, --all, --include-hidden-nodes", "hidden nodes as well"),
            option("-t, --transitions", "print the transitions that are possible, too"),
            TIMEOUT,
        ),
        ros_command(
            "lifecycle set",
            "make a transition: configure, activate, deactivate, cleanup, shutdown",
            _set,
            NODE,
            option("TRANSITION", "its label or number"),
            HIDDEN,
            option(
                "--timeout S",
                "wait S seconds for the answers of the node and for the end of the transition "
                "(default: 5 for answers, without end for the transition)",
                seconds,
            ),
        ),
    ),
)

main = functools.partial(dispatch, COMMAND)
