"""DOT: a snapshot as the source of a Graphviz drawing; nodes are ellipses, topics boxes."""

from __future__ import annotations

from collections.abc import Iterator

from launcher.graph.matching import silent_subscriptions
from launcher.graph.snapshot import Endpoint, Snapshot

_HEAD = """digraph ros {
  rankdir=LR; bgcolor="white"; nodesep=0.25; ranksep=0.7;
  node [fontname="Helvetica" fontsize=12 color="#4a5568" fontcolor="#1a202c"];
  edge [fontname="Helvetica" fontsize=10 color="#4a5568" fontcolor="#4a5568" arrowsize=0.8];"""


def to_dot(snapshot: Snapshot) -> str:
    """The drawing; subscriptions that get nothing because of their QoS are red and dashed."""
    return "\n".join([_HEAD, *_nodes(snapshot), *_topics(snapshot), *_edges(snapshot), "}", ""])


def _nodes(snapshot: Snapshot) -> Iterator[str]:
    for node in snapshot.nodes:
        yield f"  {_id('node', node)} [label={_quoted(node)} shape=ellipse {_filled('#ebf4ff')}];"


def _topics(snapshot: Snapshot) -> Iterator[str]:
    for topic in snapshot.topics():
        types = sorted({e.type for e in snapshot.endpoints if e.topic == topic})
        label = _quoted("\n".join([topic, *types]))
        yield f"  {_id('topic', topic)} [label={label} shape=box {_filled('#f7fafc')}];"


def _filled(colour: str) -> str:
    return f'style=filled fillcolor="{colour}"'


def _edges(snapshot: Snapshot) -> Iterator[str]:
    silent = silent_subscriptions(snapshot)
    for endpoint in sorted(set(snapshot.endpoints)):
        node, topic = _id("node", endpoint.node), _id("topic", endpoint.topic)
        ends = (node, topic) if endpoint.is_publisher else (topic, node)
        yield f"  {ends[0]} -> {ends[1]}{_style(endpoint, silent.get(endpoint))};"


def _style(endpoint: Endpoint, fault: str | None) -> str:
    if fault is None:
        return ""
    label = _quoted(f"nothing arrives: {fault}")
    return f' [color="#c53030" fontcolor="#c53030" style=dashed label={label}]'


def _id(kind: str, name: str) -> str:
    return _quoted(f"{kind} {name}")


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
