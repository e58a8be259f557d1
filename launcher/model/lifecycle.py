"""Lifecycle transitions of ROS 2 nodes: their numbers, labels and states. Data only."""

from __future__ import annotations

from typing import NamedTuple


class Transition(NamedTuple):
    """A transition that can be asked for, and the states on its way (of a healthy node)."""

    constant: str
    label: str
    start: str
    between: str
    goal: str
    success: str


# The numbers are those of lifecycle_msgs/msg/Transition.
TRANSITIONS = {
    0: Transition("TRANSITION_CREATE", "create", "", "", "", ""),
    1: Transition(
        "TRANSITION_CONFIGURE",
        "configure",
        "unconfigured",
        "configuring",
        "inactive",
        "transition_success",
    ),
    2: Transition(
        "TRANSITION_CLEANUP",
        "cleanup",
        "inactive",
        "cleaningup",
        "unconfigured",
        "transition_success",
    ),
    3: Transition(
        "TRANSITION_ACTIVATE",
        "activate",
        "inactive",
        "activating",
        "active",
        "transition_success",
    ),
    4: Transition(
        "TRANSITION_DEACTIVATE",
        "deactivate",
        "active",
        "deactivating",
        "inactive",
        "transition_success",
    ),
    5: Transition(
        "TRANSITION_UNCONFIGURED_SHUTDOWN",
        "shutdown",
        "unconfigured",
        "shuttingdown",
        "finalized",
        "transition_success",
    ),
    6: Transition(
        "TRANSITION_INACTIVE_SHUTDOWN",
        "shutdown",
        "inactive",
        "shuttingdown",
        "finalized",
        "transition_success",
    ),
    7: Transition(
        "TRANSITION_ACTIVE_SHUTDOWN",
        "shutdown",
        "active",
        "shuttingdown",
        "finalized",
        "transition_success",
    ),
    8: Transition("TRANSITION_DESTROY", "destroy", "", "", "", ""),
}

# The numbers are those of lifecycle_msgs/msg/State.
STATES = {
    0: "PRIMARY_STATE_UNKNOWN",
    1: "PRIMARY_STATE_UNCONFIGURED",
    2: "PRIMARY_STATE_INACTIVE",
    3: "PRIMARY_STATE_ACTIVE",
    4: "PRIMARY_STATE_FINALIZED",
    10: "TRANSITION_STATE_CONFIGURING",
    11: "TRANSITION_STATE_CLEANINGUP",
    12: "TRANSITION_STATE_SHUTTINGDOWN",
    13: "TRANSITION_STATE_ACTIVATING",
    14: "TRANSITION_STATE_DEACTIVATING",
    15: "TRANSITION_STATE_ERRORPROCESSING",
}


def transition_steps(transition_id: int) -> list[tuple[str, str, str]]:
    """(label, start state, goal state) of each event that a healthy node tells."""
    transition = TRANSITIONS[transition_id]
    if not transition.goal:
        return []
    return [
        (transition.label, transition.start, transition.between),
        (transition.success, transition.between, transition.goal),
    ]
