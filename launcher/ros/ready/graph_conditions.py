"""Whether facts of `ready_when` hold, by a view of the graph."""

from __future__ import annotations

import fnmatch
from typing import NamedTuple

from launcher.base.model.supervision import Fact
from launcher.ros.ready.views import GraphView
from launcher.ros.snapshot.ros_graph import Direction

CALLED = ("message", "service", "lifecycle")  # kinds for which the graph alone is not enough


class Seen(NamedTuple):
    """Whether a fact holds, and what is seen instead."""

    holds: bool
    text: str = ""


class WatchedFact(NamedTuple):
    """A fact that a run waits for; of the process itself only what is there since its start."""

    fact: Fact
    started_s: float

    @property
    def since_s(self) -> float:
        return self.started_s if self.fact.is_own else 0.0

    @property
    def needs_node(self) -> bool:
        """Whether a node of rclpy is needed, to receive or to call something."""
        return self.fact.kind in CALLED and self.fact.call


def in_graph(watched: WatchedFact, view: GraphView) -> Seen:
    """Whether the graph has what a fact names."""
    fact, subject = watched.fact, watched.fact.subject
    match fact.kind:
        case "node":
            names = list(view.nodes(watched.since_s))
            return Seen(any(_fits(name, subject) for name in names), f"no node {subject}")
        case "service":
            types = view.service_types(subject)
            if types and fact.type is not None and fact.type not in types:
                return Seen(False, f"service {subject} has the type {', '.join(types)}")
            return Seen(bool(types), f"no service {subject}")
        case "lifecycle":
            offered = view.service_types(f"{fact.node}/get_state", watched.since_s)
            return Seen(bool(offered), f"no lifecycle node {fact.node}")
    side = Direction.SUBSCRIPTION if fact.kind == "subscription" else Direction.PUBLISHER
    nodes = [info.node for info in view.infos(subject, side, watched.since_s)]
    if any(_fits(node, fact.node or "*") for node in nodes):
        return Seen(True)
    others = f", only of {', '.join(sorted(filter(None, set(nodes))))}" if any(nodes) else ""
    of = f" of {fact.node}{others}" if others else ""
    return Seen(False, f"no {side.value} on {subject}{of}")


def _fits(name: str, pattern: str) -> bool:
    return fnmatch.fnmatchcase(name, pattern)
