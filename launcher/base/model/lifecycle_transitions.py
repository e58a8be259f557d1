"""Lifecycle transitions of ROS 2 nodes: their numbers, labels and states. Data only."""

from __future__ import annotations

from typing import NamedTuple


class Transition(NamedTuple):
    """A transition that can be requested, and the states on its way (of a healthy node)."""

    constant: str
    label: str
    start: str
    between: str
    goal: str
    success: str


def _transition(constant: str, label: str, start: str, between: str, goal: str) -> Transition:
    success = "transition_success" if goal else ""
    return Transition(f"TRANSITION_{constant}", label, start, between, goal, success)


# The numbers are those of lifecycle_msgs/msg/Transition.
TRANSITIONS = {
    0: _transition("CREATE", "create", "", "", ""),
    1: _transition("CONFIGURE", "configure", "unconfigured", "configuring", "inactive"),
    2: _transition("CLEANUP", "cleanup", "inactive", "cleaningup", "unconfigured"),
    3: _transition("ACTIVATE", "activate", "inactive", "activating", "active"),
    4: _transition("DEACTIVATE", "deactivate", "active", "deactivating", "inactive"),
    5: _transition(
        "UNCONFIGURED_SHUTDOWN", "shutdown", "unconfigured", "shuttingdown", "finalized"
    ),
    6: _transition("INACTIVE_SHUTDOWN", "shutdown", "inactive", "shuttingdown", "finalized"),
    7: _transition("ACTIVE_SHUTDOWN", "shutdown", "active", "shuttingdown", "finalized"),
    8: _transition("DESTROY", "destroy", "", "", ""),
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
    """(label, start state, goal state) of each event that a healthy node publishes."""
    transition = TRANSITIONS[transition_id]
    if not transition.goal:
        return []
    return [
        (transition.label, transition.start, transition.between),
        (transition.success, transition.between, transition.goal),
    ]
