"""`topic list`, `info`, `type` and `find` of a graph, in the format of ros2cli."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from launcher.base.ros_errors import VerbError, did_you_mean
from launcher.ros.snapshot.qos_matching import Mismatch, explain, mismatches
from launcher.ros.snapshot.ros_graph import Direction, GraphSnapshot, is_hidden

# every node of ros2cli has these two, so `ros2 topic list` always shows them
ALWAYS = {
    "/parameter_events": ["rcl_interfaces/msg/ParameterEvent"],
    "/rosout": ["rcl_interfaces/msg/Log"],
}


@dataclass(frozen=True, slots=True, kw_only=True)
class ListedTopic:
    """A topic and how many use it."""

    name: str
    types: tuple[str, ...]
    publishers: int
    subscriptions: int

    @property
    def label(self) -> str:
        return f"{self.name} [{', '.join(self.types)}]"

    def document(self) -> dict[str, object]:
        return {
            "name": self.name,
            "types": list(self.types),
            "publisher_count": self.publishers,
            "subscription_count": self.subscriptions,
        }


def known_types(graph: GraphSnapshot) -> dict[str, list[str]]:
    """Every topic and its types, sorted by name."""
    return dict(sorted({**ALWAYS, **graph.topic_types()}.items()))


def listed(graph: GraphSnapshot, *, hidden: bool) -> list[ListedTopic]:
    return [
        ListedTopic(
            name=name,
            types=tuple(types),
            publishers=len(graph.on(name, Direction.PUBLISHER)),
            subscriptions=len(graph.on(name, Direction.SUBSCRIPTION)),
        )
        for name, types in known_types(graph).items()
        if hidden or not is_hidden(name)
    ]


def verbose_listing(topics: list[ListedTopic]) -> Iterator[str]:
    """The lines of `topic list -v`."""
    for title, noun, counted in (
        ("Published topics:", "publisher", [(t, t.publishers) for t in topics]),
        ("Subscribed topics:", "subscriber", [(t, t.subscriptions) for t in topics]),
    ):
        yield title
        for topic, count in counted:
            if count:
                yield f" * {topic.label} {count} {noun}{'s' if count > 1 else ''}"
        yield ""


def types_of(graph: GraphSnapshot, name: str) -> list[str]:
    """The types of a topic; VerbError with the text of ros2cli if it has no endpoint."""
    topics = graph.topic_types()
    used = name in topics and graph.endpoints(name)
    if used:
        return topics[name]
    visible = [n for n in known_types(graph) if not is_hidden(n)]
    raise VerbError(f"Unknown topic '{name}'", hint=did_you_mean(name, visible))


def info_lines(graph: GraphSnapshot, name: str, *, verbose: bool) -> Iterator[str]:
    """The lines of `topic info`, as ros2cli prints them."""
    types = types_of(graph, name)
    yield f"Type: {types[0] if len(types) == 1 else types}"
    if verbose:
        yield ""
    for direction in Direction:
        infos = graph.on(name, direction)
        yield f"{direction.value.capitalize()} count: {len(infos)}"
        if verbose:
            yield from ("", *(f"{info}\n" for info in infos))


def info_document(graph: GraphSnapshot, name: str) -> Mapping[str, Any]:
    """`topic info --json`: the endpoints with their QoS, and the pairs that do not match."""
    types = types_of(graph, name)
    endpoints = graph.endpoints(name)
    return {
        "name": name,
        "types": types,
        "endpoints": [endpoint_document(e) for e in endpoints],
        "mismatches": mismatch_documents(mismatches(endpoints)),
        "explanation": explain(endpoints),
    }


def mismatch_documents(found: Iterable[Mismatch]) -> list[dict[str, Any]]:
    return [
        {
            "subscription": m.subscription.node,
            "publishers": [e.node for e in m.publishers],
            "policies": [
                {
                    "policy": f.policy,
                    "offered": f.offered,
                    "requested": f.requested,
                    "advice": f.advice,
                }
                for f in m.faults
            ],
        }
        for m in found
    ]


def endpoint_document(endpoint: object) -> dict[str, Any]:
    """The fields of an endpoint but its topic."""
    names = ("node", "direction", "type", "reliability", "durability", "liveliness")
    times = ("deadline_ns", "lease_ns")
    return {name: getattr(endpoint, name) for name in (*names, *times, "gid")}
