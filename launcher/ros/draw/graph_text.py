"""A graph as text, by node: what it publishes to whom and receives from whom."""

from __future__ import annotations

from collections.abc import Iterator

from launcher.base.text import count
from launcher.ros.draw.filter import Mode
from launcher.ros.snapshot.qos_matching import TopicLink, links
from launcher.ros.snapshot.ros_graph import Endpoint, TopicGraph


def to_tree(snapshot: TopicGraph, mode: Mode = Mode.ALL) -> str:
    found = links(snapshot.endpoints)
    lines: list[str] = []
    for node in dict.fromkeys(snapshot.nodes):
        lines.append(node + _mark(node, snapshot))
        lines += _neighbours(node, found) if mode is Mode.NODES else _ends(node, snapshot, found)
    return "\n".join([*lines, _summary(snapshot, found), ""])


def _mark(node: str, snapshot: TopicGraph) -> str:
    count = snapshot.nodes.count(node)
    twins = f"  ({count} nodes of this name)" if count > 1 else ""
    return twins + ("  GHOST: its process is gone" if node in snapshot.ghosts else "")


def _ends(node: str, snapshot: TopicGraph, found: list[TopicLink]) -> Iterator[str]:
    own = sorted(
        {(not e.is_publisher, e.topic): e for e in snapshot.endpoints if e.node == node}.items()
    )
    for index, (_, endpoint) in enumerate(own):
        branch = "└─" if index == len(own) - 1 else "├─"
        yield f"{branch} {_end(endpoint, found)}"


def _end(endpoint: Endpoint, found: list[TopicLink]) -> str:
    arrow, side = ("->", "target") if endpoint.is_publisher else ("<-", "source")
    own = "source" if endpoint.is_publisher else "target"
    others = [
        getattr(link, side) + (f" (nothing arrives: {link.fault})" if link.fault else "")
        for link in found
        if link.topic == endpoint.topic and getattr(link, own) == endpoint.node
    ]
    return f"{arrow} {endpoint.topic} [{endpoint.type}] {arrow} {', '.join(others) or '(none)'}"


def _neighbours(node: str, found: list[TopicLink]) -> Iterator[str]:
    own = [link for link in found if link.source == node]
    for index, link in enumerate(own):
        branch = "└─" if index == len(own) - 1 else "├─"
        fault = f" (nothing arrives: {link.fault})" if link.fault else ""
        yield f"{branch} -> {link.target} by {link.topic}{fault}"


def _summary(snapshot: TopicGraph, found: list[TopicLink]) -> str:
    parts = [count(len(snapshot.nodes), "node"), count(len(snapshot.topics()), "topic")]
    if faults := sum(link.fault is not None for link in found):
        parts.append(count(faults, "connection") + " on which nothing arrives")
    if snapshot.ghosts:
        parts.append(count(len(snapshot.ghosts), "ghost"))
    return ", ".join(parts)
