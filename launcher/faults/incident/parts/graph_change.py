"""What changed between two graphs of the probe, in words; and graphs for drawing. No I/O."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from launcher.base.text import count, several
from launcher.faults.incident.markup import plain
from launcher.ros.snapshot.ros_graph import DEBUG_TOPICS, Endpoint, TopicGraph, is_hidden

_QOS = ("reliability", "durability", "liveliness")


@dataclass(frozen=True, slots=True)
class KnownGraph:
    """A graph of the probe as far as it can be read; names are printable.

    `pids` has the processes of nodes; `mismatches` are sentences.
    """

    graph: TopicGraph
    pids: Mapping[str, int] = field(default_factory=dict)
    mismatches: tuple[str, ...] = ()

    @property
    def living(self) -> Counter[str]:
        return Counter(name for name in self.graph.nodes if name not in self.graph.ghosts)


def known_graph(document: object) -> KnownGraph | None:
    """Without hidden nodes and the topics of every node; None for what is no graph."""
    if not isinstance(document, Mapping) or not isinstance(document.get("nodes"), list):
        return None
    nodes: list[str] = []
    ghosts: list[str] = []
    pids: dict[str, int] = {}
    for one in _objects(document["nodes"]):
        name = _name(one, "name")
        if name and not is_hidden(name):
            number = one.get("count")
            nodes += [name] * (min(number, 99) if isinstance(number, int) and number > 0 else 1)
            ghosts += [name] if one.get("ghost") is True else []
            if isinstance(one.get("pid"), int):
                pids[name] = one["pid"]
    known = set(nodes)
    endpoints = [_endpoint(one) for one in _objects(document.get("endpoints"))]
    kept = {one for one in endpoints if one.node in known and _is_shown(one.topic)}
    graph = TopicGraph(
        nodes=tuple(sorted(nodes)), endpoints=tuple(sorted(kept)), ghosts=tuple(sorted(ghosts))
    )
    return KnownGraph(graph, pids, tuple(_mismatches(document.get("mismatches"))))


def _objects(value: object) -> Iterator[Mapping[str, Any]]:
    if isinstance(value, list):
        yield from (one for one in value if isinstance(one, Mapping))


def _name(value: Mapping[str, Any], key: str) -> str:
    name = value.get(key)
    return plain(name)[:300] if isinstance(name, str) else ""


def _is_shown(topic: str) -> bool:
    return bool(topic) and topic not in DEBUG_TOPICS and not is_hidden(topic)


def _endpoint(value: Mapping[str, Any]) -> Endpoint:
    return Endpoint(
        topic=_name(value, "topic"),
        node=_name(value, "node"),
        direction="publisher" if value.get("direction") == "publisher" else "subscription",
        type=_name(value, "type"),
        reliability=_name(value, "reliability"),
        durability=_name(value, "durability"),
        liveliness=_name(value, "liveliness") or "AUTOMATIC",
        gid="ghost" if value.get("ghost") is True else "",
    )


def _mismatches(value: object) -> Iterator[str]:
    for one in _objects(value):
        publishers = one.get("publishers")
        names = publishers if isinstance(publishers, list) else []
        whom = several([str(name) for name in names]) or "the publishers"
        text = f"{one.get('subscription')} receives nothing on {one.get('topic')} from {whom}"
        reasons = [
            f"{why.get('policy')} {why.get('offered')} is offered, {why.get('requested')} requested"
            for why in _objects(one.get("policies"))
        ]
        yield f"{text}: {'; '.join(reasons)}" if reasons else text


# ---- words


def changes(before: KnownGraph, after: KnownGraph) -> list[str]:
    """Sentences; empty if nothing changed."""
    return [*_nodes(before, after), *_topics(before, after), *_new_mismatches(before, after)]


def _nodes(before: KnownGraph, after: KnownGraph) -> Iterator[str]:
    old, new = before.living, after.living
    for name in sorted(old.keys() - new.keys()):
        ghost = (
            " (DDS still lists it: its process was killed)" if name in after.graph.ghosts else ""
        )
        yield f"Node {name} has gone{ghost}."
    for name in sorted(new.keys() - old.keys()):
        yield f"Node {name} is new."
    for name in sorted(old.keys() & new.keys()):
        if old[name] != new[name]:
            yield f"Node {name} exists {count(new[name], 'time')}, {old[name]} before."
        elif before.pids.get(name, 0) != after.pids.get(name, 0) and name in after.pids:
            yield f"Node {name} is that of another process: pid {after.pids[name]}."


def _topics(before: KnownGraph, after: KnownGraph) -> Iterator[str]:
    for topic in sorted({*before.graph.topics(), *after.graph.topics()}):
        old, new = _sides(before.graph, topic), _sides(after.graph, topic)
        lost, come = old - new, new - old
        if not new:
            yield f"Topic {topic} has gone, with its {_ends(lost)}."
        elif not old:
            yield f"Topic {topic} is new, with its {_ends(come)}."
        elif lost or come:
            words = [
                f"lost its {_ends(lost)}" if lost else "",
                f"got a new {_ends(come)}" if come else "",
            ]
            yield f"Topic {topic} has {' and '.join(filter(None, words))}{_left(new, lost)}."


def _sides(graph: TopicGraph, topic: str) -> set[tuple[str, str]]:
    """(direction, node) of the endpoints that live."""
    return {(e.direction, e.node) for e in graph.on(topic) if not e.gid}


def _ends(sides: set[tuple[str, str]]) -> str:
    """`publisher /a and subscription /b`."""
    words = []
    for direction in ("publisher", "subscription"):
        names = sorted(node for side, node in sides if side == direction)
        if names:
            words.append(f"{direction}{'s' * (len(names) > 1)} {several(names)}")
    return " and ".join(words)


def _left(new: set[tuple[str, str]], lost: set[tuple[str, str]]) -> str:
    sides = {direction for direction, _ in lost}
    missing = [side for side in sorted(sides) if side not in {direction for direction, _ in new}]
    return f": it has no {' and no '.join(missing)} now" if missing else ""


def _new_mismatches(before: KnownGraph, after: KnownGraph) -> Iterator[str]:
    for text in after.mismatches:
        known = " (as before)" if text in before.mismatches else ""
        yield f"QoS: {text}{known}."


def focus(known: KnownGraph, names: set[str], topics: set[str]) -> TopicGraph:
    """These nodes and topics with their neighbours; all of the graph if none of them is in it."""
    graph = known.graph
    touched = {e.topic for e in graph.endpoints if e.node in names or e.topic in topics}
    kept = tuple(e for e in graph.endpoints if e.topic in touched)
    nodes = {e.node for e in kept} | names
    if not kept and not names & set(graph.nodes):
        return graph
    return TopicGraph(
        nodes=tuple(name for name in graph.nodes if name in nodes),
        endpoints=kept,
        ghosts=tuple(name for name in graph.ghosts if name in nodes),
    )
