"""A graph as SVG in the page: what Graphviz draws is read, and its known elements written again.

So names of nodes cannot bring elements or attributes into the page, and drawings have its colours.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from launcher.base import xml_tree
from launcher.base.errors import LauncherError
from launcher.base.xml_tree import XmlElement
from launcher.faults.incident.markup import EMPTY, Markup, join, tag
from launcher.ros.draw.dot import to_dot, to_svg
from launcher.ros.snapshot.ros_graph import TopicGraph

MAX_NODES, MAX_ENDPOINTS = 80, 400  # a larger graph takes Graphviz too long, and nobody can read it
_SHAPES = {
    "path": ("d",),
    "polygon": ("points",),
    "ellipse": ("cx", "cy", "rx", "ry"),
}
_NUMBERS = re.compile(r"[\d\s.,MCLHVZz+-]*")
_TRANSFORM = re.compile(r"[a-z\d\s().,+-]*")
_BOX = re.compile(r"[\d.\s-]+")
# The colours of `draw.dot`, and the classes that stand for them.
_FILLS = {"#ebf4ff": "node", "#f7fafc": "topic", "white": "ground", "none": "none"}
_RED = "#c53030"  # of ghosts, and of subscriptions that receive nothing


def drawn(graph: TopicGraph, marks: Mapping[str, str], title: str) -> Markup | None:
    """The drawing; None if the graph is empty or too large, or Graphviz is not installed.

    `marks` are classes of nodes and topics, by `node NAME` and `topic NAME`.
    """
    if not graph.nodes or len(graph.nodes) > MAX_NODES or len(graph.endpoints) > MAX_ENDPOINTS:
        return None
    try:
        source = to_svg(to_dot(graph))
        root = xml_tree.parse(source[source.index("<svg") :])
    except (LauncherError, xml_tree.XmlError, ValueError):
        return None
    box = root.attributes.get("viewBox", "")
    if not _BOX.fullmatch(box):
        return None
    width = box.split()[2] if len(box.split()) == 4 else "600"
    inside = join(_element(one, marks, "") for one in root.children)
    return tag(
        "svg",
        tag("title", title),
        inside,
        viewBox=box,
        role="img",
        style=f"width:{float(width) * 1.2:.0f}px",
    )


def _element(element: XmlElement, marks: Mapping[str, str], group: str) -> Markup:
    name, attributes = _local(element), element.attributes
    if name == "g":
        return _group(element, marks)
    if name == "text":
        keys = ("x", "y", "text-anchor", "font-size")
        kept = {key: attributes[key] for key in keys if key in attributes}
        bad = "red" if attributes.get("fill") == _RED else None
        return tag("text", element.text, **kept, class_=bad)
    if name not in _SHAPES:
        return EMPTY  # titles, comments, links
    values = {key: attributes.get(key, "") for key in _SHAPES[name]}
    if not all(_NUMBERS.fullmatch(value) for value in values.values()):
        return EMPTY
    fill = _FILLS.get(attributes.get("fill", ""), "none")
    if name == "polygon" and group == "edge":
        fill = "tip"
    bad = " red" if attributes.get("stroke") == _RED else ""
    return tag(name, **values, class_=f"fill-{fill}{bad}")


def _local(element: XmlElement) -> str:
    """The name without its namespace."""
    return element.name.rpartition("}")[2]


def _group(element: XmlElement, marks: Mapping[str, str]) -> Markup:
    kind = element.attributes.get("class", "")
    kind = kind if kind in ("graph", "node", "edge", "cluster") else ""
    title = next((one.text for one in element.children if _local(one) == "title"), "")
    transform = element.attributes.get("transform")
    if transform is not None and not _TRANSFORM.fullmatch(transform):
        transform = None
    state = _mark(title, kind, marks)
    inside = [_element(one, marks, kind) for one in element.children]
    # The ground of the drawing is that of the page.
    if kind == "graph":
        inside = [one for one in inside if "fill-ground" not in one or one.startswith("<g")]
    return tag("g", *inside, class_=f"g-{kind} {state}".strip(), transform=transform)


def _mark(title: str, kind: str, marks: Mapping[str, str]) -> str:
    """Of an edge, that of either end."""
    if kind != "edge":
        return marks.get(title, "")
    ends = re.split(r"->(?=node |topic )", title)
    found = [marks[end] for end in ends if end in marks]
    return found[0] if found else ""
