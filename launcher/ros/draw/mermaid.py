"""A graph as a Mermaid flowchart for Markdown pages."""

from __future__ import annotations

from collections.abc import Iterator

from launcher.ros.draw.filter import Mode
from launcher.ros.snapshot.qos_matching import links, silent_subscriptions
from launcher.ros.snapshot.ros_graph import TopicGraph


def to_mermaid(snapshot: TopicGraph, mode: Mode = Mode.ALL) -> str:
    """The source of the flowchart; ghosts and unmatched subscriptions are red."""
    nodes = {name: f"n{index}" for index, name in enumerate(dict.fromkeys(snapshot.nodes))}
    known = () if mode is Mode.NODES else snapshot.topics()
    topics = {name: f"t{index}" for index, name in enumerate(known)}
    for endpoint in snapshot.endpoints:  # a node may be missing in `nodes`
        nodes.setdefault(endpoint.node, f"n{len(nodes)}")
    shapes = [f"  {key}([{_quoted(name)}])" for name, key in nodes.items()]
    shapes += [f"  {key}[{_quoted(name)}]" for name, key in topics.items()]
    edges = list(_links(snapshot, nodes) if mode is Mode.NODES else _edges(snapshot, nodes, topics))
    lines = ["flowchart LR", *shapes, *(edge for edge, _ in edges)]
    red = [str(index) for index, (_, fault) in enumerate(edges) if fault]
    if red:
        lines.append(f"  linkStyle {','.join(red)} stroke:#c53030,color:#c53030")
    if ghosts := [nodes[name] for name in snapshot.ghosts if name in nodes]:
        lines.append(f"  style {','.join(ghosts)} stroke:#c53030,stroke-dasharray:4")
    return "\n".join([*lines, ""])


def _edges(
    snapshot: TopicGraph, nodes: dict[str, str], topics: dict[str, str]
) -> Iterator[tuple[str, str | None]]:
    silent = silent_subscriptions(snapshot)
    for endpoint in sorted(set(snapshot.endpoints)):
        node, topic = nodes[endpoint.node], topics[endpoint.topic]
        fault = silent.get(endpoint)
        if endpoint.is_publisher:
            yield f"  {node} --> {topic}", None
        elif fault:
            yield f"  {topic} -. {_quoted(f'nothing arrives: {fault}')} .-> {node}", fault
        else:
            yield f"  {topic} --> {node}", None


def _links(snapshot: TopicGraph, nodes: dict[str, str]) -> Iterator[tuple[str, str | None]]:
    for link in links(snapshot.endpoints):
        source, target = nodes[link.source], nodes[link.target]
        if link.fault:
            label = _quoted(f"{link.topic}: nothing arrives: {link.fault}")
            yield f"  {source} -. {label} .-> {target}", link.fault
        else:
            yield f"  {source} -- {_quoted(link.topic)} --> {target}", None


def _quoted(text: str) -> str:
    return '"' + text.replace("&", "#amp;").replace('"', "#quot;").replace("<", "#lt;") + '"'
