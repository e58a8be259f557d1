"""The graph before and after an incident, drawn or as a table, with the difference in words."""

from __future__ import annotations

from collections.abc import Iterable

from launcher.base.text import count, several
from launcher.faults.incident.document import IncidentDocument, label_of
from launcher.faults.incident.limits import PageLimits
from launcher.faults.incident.markup import EMPTY, Markup, details, plain, section, tag
from launcher.faults.incident.parts import graph_drawing
from launcher.faults.incident.parts.graph_change import KnownGraph, changes, focus, known_graph
from launcher.ros.snapshot.ros_graph import TopicGraph

MAX_CHANGES = 60
MAX_ROWS = 300


def graphs(incident: IncidentDocument, limits: PageLimits) -> Markup:
    before = known_graph(incident.graphs.get("before"))
    after = known_graph(incident.graphs.get("after"))
    found = [one for one in (before, after) if one is not None]
    if not found:
        return EMPTY
    names, topics = _in_question(incident, found)
    marks: dict[str, str] = {}
    if before is not None and after is not None:
        marks = _marks(before, after)
        names |= {key.removeprefix("node ") for key in marks if key.startswith("node ")}
        topics |= {key.removeprefix("topic ") for key in marks if key.startswith("topic ")}
    shown = []
    for title, one in (("Before", before), ("After", after)):
        if one is not None:
            shown.append(_figure(title, one, focus(one, names, topics), marks, limits))
    return section(
        "graph", "Graph", _difference(before, after), tag("div", *shown, class_="graphs")
    )


def _in_question(
    incident: IncidentDocument, found: Iterable[KnownGraph]
) -> tuple[set[str], set[str]]:
    """Nodes and topics of the faults, and the nodes of their processes, by their names."""
    labels = {label_of(name) for one in incident.faults for name in one.processes}
    names = {plain(name) for one in incident.faults for name in one.nodes}
    for one in found:
        names |= {name for name in one.graph.nodes if name.rpartition("/")[2] in labels}
    topics = {plain(name) for one in incident.faults for name in one.topics}
    return names, topics


def _marks(before: KnownGraph, after: KnownGraph) -> dict[str, str]:
    """What has gone or is new, as `graph_drawing` takes it."""
    old, new = before.living.keys(), after.living.keys()
    marks = {f"node {name}": "gone" for name in old - new}
    marks |= {f"node {name}": "new" for name in new - old}
    topics, later = set(before.graph.topics()), set(after.graph.topics())
    marks |= {f"topic {name}": "gone" for name in topics - later}
    marks |= {f"topic {name}": "new" for name in later - topics}
    return marks


def _difference(before: KnownGraph | None, after: KnownGraph | None) -> Markup:
    if before is None or after is None:
        return EMPTY
    found = changes(before, after)
    if not found:
        return tag("p", "Nodes, topics, publishers and subscriptions are the same as before.")
    rows = [tag("li", one) for one in found[:MAX_CHANGES]]
    more = len(found) - MAX_CHANGES
    rows += [tag("li", f"{more} more changes")] if more > 0 else []
    return tag("ul", *rows, class_="changes")


def _figure(
    title: str,
    known: KnownGraph,
    shown: TopicGraph,
    marks: dict[str, str],
    limits: PageLimits,
) -> Markup:
    whole = known.graph
    about = f"{count(len(whole.nodes), 'node')}, {count(len(whole.topics()), 'topic')}"
    if len(shown.nodes) < len(whole.nodes) or len(shown.topics()) < len(whole.topics()):
        about += f"; here those in question ({len(shown.nodes)} and {len(shown.topics())})"
    drawing = graph_drawing.drawn(shown, marks, f"The graph {title.lower()}: {about}")
    table = _table(whole, limits.of(MAX_ROWS))
    parts = [tag("figcaption", tag("strong", title), " ", tag("span", about, class_="muted"))]
    if drawing is None:
        parts.append(table)
    else:
        parts += [
            tag("div", drawing, class_="drawing", tabindex="0"),
            details("All nodes as a table", table),
        ]
    return tag("figure", *parts, class_="graph")


def _table(graph: TopicGraph, most: int) -> Markup:
    head = tag(
        "tr", *(tag("th", name, scope="col") for name in ("Node", "Publishes", "Subscribes to"))
    )
    names = list(dict.fromkeys(graph.nodes))
    rows = []
    for name in names[:most]:
        own = [one for one in graph.endpoints if one.node == name]
        ghost = " (ghost: its process is gone)" if name in graph.ghosts else ""
        sent = several((e.topic for e in own if e.is_publisher), 12)
        received = several((e.topic for e in own if not e.is_publisher), 12)
        rows.append(tag("tr", tag("td", name + ghost), tag("td", sent), tag("td", received)))
    more = len(names) - most
    if more > 0:
        rows.append(tag("tr", tag("td", f"{more} more nodes", colspan=3)))
    return tag("table", tag("thead", head), tag("tbody", *rows), class_="nodes")
