"""Lifecycle nodes in a graph: what state they are in, and which transitions they can make."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState

from launcher.base.model.lifecycle_transitions import TRANSITIONS
from launcher.base.model.ros_names import full_name
from launcher.base.ros_errors import VerbError, did_you_mean
from launcher.base.text import did_you_mean as near_word
from launcher.ros.discovery.completeness import settled_graph
from launcher.ros.helpers.lifecycle_client import REFUSED, LifecycleClient
from launcher.ros.service_caller import NoAnswerError, ServiceCaller, silence

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer

_GONE_S = 2.0  # without its services, a node is gone


def prepare(caller: ServiceCaller, node: str) -> None:
    """Create a client, which is slow, while the node is being discovered; VerbError."""
    caller.client(GetState, f"{node}/get_state")


def require(observer: Observer, name: str, spin_time_s: float) -> str:
    """The full name of a lifecycle node; VerbError with the text of ros2cli if it is none."""
    full = full_name(name)
    graph = settled_graph(observer, spin_time_s, lambda graph: graph.is_lifecycle(full))
    if graph.is_lifecycle(full):
        return full
    if full in graph.nodes:
        raise VerbError(
            "Node not found", hint=f"'{full}' has no lifecycle; those that have: lifecycle nodes"
        )
    known = graph.lifecycle_nodes()
    hint = did_you_mean(full, known)
    none = "there are no lifecycle nodes" if not known else None
    raise VerbError("Node not found", hint=hint or none)


def states(caller: ServiceCaller, nodes: list[str]) -> Iterator[tuple[str, Any]]:
    """Each node and its state, None if it does not answer in time, as soon as it does."""
    for node, answer in caller.ask_each(GetState, nodes, "get_state", GetState.Request()):
        yield node, answer and answer.current_state


def silence_of(node: str, limit_s: float) -> NoAnswerError:
    """The error of a node that has not answered for its state."""
    return silence(f"{node}/get_state", limit_s)


def transitions(caller: ServiceCaller, node: str, *, every: bool = False) -> list[Any]:
    """The transitions that are possible now, or every one that there is."""
    service = "get_transition_graph" if every else "get_available_transitions"
    request = GetAvailableTransitions.Request()
    answer = caller.ask(GetAvailableTransitions, f"{node}/{service}", request)
    return list(answer.available_transitions)


def find(available: list[Any], word: str) -> Any:
    """The transition with this label or number; VerbError with the text of ros2cli."""
    possible = [one.transition for one in available]
    for transition in possible:
        if transition.label == word:
            return transition
    for transition in possible:
        if str(transition.id) == word:
            return transition
    lines = "".join(f"\n- {one.label} [{one.id}]" for one in possible)
    raise VerbError(
        f"Unknown transition requested, available ones are:{lines}",
        hint=near_word(word, [one.label for one in possible]),
    )


def change(caller: ServiceCaller, node: str, transition: Any, limit_s: float | None) -> None:
    """Make a transition, however long it takes; VerbError if it fails, or after `limit_s`."""
    limit_s = math.inf if limit_s is None else limit_s
    if not (known := TRANSITIONS.get(transition.id)) or not known.goal:
        request = ChangeState.Request(transition=transition)
        succeeded = caller.call(ChangeState, f"{node}/change_state", request, limit_s).success
        problem = None if succeeded else REFUSED
    else:
        problem = _requested(caller, node, transition, limit_s)
    if problem is not None:
        hint = f"'{node}' refused it, or a callback of it failed: its log may say why"
        raise VerbError("Transitioning failed", hint=hint if problem == REFUSED else problem)


def _requested(caller: ServiceCaller, node: str, transition: Any, limit_s: float) -> str | None:
    """What is wrong, None for nothing; NoAnswerError after `limit_s`."""
    outcome: list[str | None] = []
    client = LifecycleClient(caller.node, node, lambda *_: None)
    change = caller.client(ChangeState, f"{node}/change_state")
    seen_s = time.monotonic()

    def is_over() -> bool:
        nonlocal seen_s
        client.poll()
        if change.service_is_ready():
            seen_s = time.monotonic()
        elif time.monotonic() - seen_s > _GONE_S:
            outcome.append("the node is gone")
        return bool(outcome)

    caller.await_introduction()
    client.request(transition.id, transition.label, outcome.append)
    caller.spin_until(is_over, limit_s)
    if not outcome:
        raise NoAnswerError(
            f"'{node}' has not ended the transition after {limit_s:g} s",
            hint=f"it may go on: lifecycle get {node}",
        )
    return outcome[0]
