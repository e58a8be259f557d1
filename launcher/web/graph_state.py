"""The graph as the pages see it: nodes that went stay for a while, each with its process.

A node whose process died or was killed from outside stays GONE_S. One that was closed by its
process, whose process was stopped on request or returned 0, or that is not of this run, stays
GONE_CLEAN_S: long enough to be seen. Hidden nodes, of tools mostly, do not stay.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

GONE_S = 600.0
GONE_CLEAN_S = 30.0
_PARTING_S = 5.0  # a node that shuts down loses its endpoints one after the other
_ALIVE = frozenset({"STARTING", "RUNNING", "STOPPING"})

Document = dict[str, Any]
Rows = Sequence[Document]


class GraphState:
    """Takes the probe's documents; `document` is what the pages get."""

    def __init__(self) -> None:
        self._graph: Document | None = None
        self._gone: dict[str, Document] = {}  # node -> its row, with `endpoints`
        self._ghost_since: dict[str, float] = {}
        self._processes: dict[str, str] = {}  # node -> process that had it
        self._types: dict[str, list[str]] = {}  # of topics
        self._lost: list[tuple[float, Document]] = []  # endpoints that went, and when

    def take(self, graph: Document, rows: Rows, wall: float) -> None:
        """A new graph of the probe; what it lacks since the last one has gone."""
        before, self._graph = self._graph, graph
        present = {node["name"] for node in graph["nodes"]}
        self._learn(graph, rows, wall)
        for name in present:
            self._gone.pop(name, None)
        if before is not None:
            self._note_lost(before, wall)
            for node in before["nodes"]:
                if node["name"] not in present and not node["hidden"]:
                    self._gone[node["name"]] = self._kept(node, wall)
        self._forget_unused(graph)
        ghosts = {node["name"] for node in graph["nodes"] if node["ghost"]}
        self._ghost_since = {n: t for n, t in self._ghost_since.items() if n in ghosts}

    def restart(self) -> None:
        """The next graph is that of a new probe, which has not discovered everything."""
        self._graph = None

    def forget(self, node: str) -> bool:
        """Stop keeping a node that has gone."""
        return self._gone.pop(node, None) is not None

    def document(self, rows: Rows, wall: float) -> Document | None:
        """The graph with the nodes that have gone; None before the first graph."""
        if self._graph is None:
            return None
        self._expire(rows, wall)
        graph = self._graph
        nodes = [self._present(node, rows) for node in graph["nodes"]]
        gone = [
            {key: value for key, value in node.items() if key != "endpoints"}
            for node in self._gone.values()
        ]
        endpoints = list(graph["endpoints"])
        for node in self._gone.values():
            endpoints += node["endpoints"]
        return {
            **graph,
            "nodes": nodes + gone,
            "endpoints": endpoints,
            "topics": self._topics(graph["topics"], endpoints),
        }

    # ---- parts

    def _learn(self, graph: Document, rows: Rows, wall: float) -> None:
        for node in graph["nodes"]:
            process = process_of(node["name"], node["pid"], rows)
            if process is not None:
                self._processes[node["name"]] = process
            if node["ghost"]:
                self._ghost_since.setdefault(node["name"], wall)
        for topic in graph["topics"]:
            if topic["types"]:
                self._types[topic["name"]] = topic["types"]

    def _forget_unused(self, graph: Document) -> None:
        """Forget what is known of nodes and topics that are not shown any more."""
        shown = {node["name"] for node in graph["nodes"]} | self._gone.keys()
        self._processes = {n: process for n, process in self._processes.items() if n in shown}
        endpoints = [one for node in self._gone.values() for one in node["endpoints"]]
        topics = {topic["name"] for topic in graph["topics"]} | {one["topic"] for one in endpoints}
        self._types = {name: types for name, types in self._types.items() if name in topics}

    def _note_lost(self, before: Document, wall: float) -> None:
        assert self._graph is not None
        there = {_key(one) for one in self._graph["endpoints"]}
        self._lost = [(at, one) for at, one in self._lost if wall - at < _PARTING_S]
        self._lost += [(wall, one) for one in before["endpoints"] if _key(one) not in there]

    def _kept(self, node: Document, wall: float) -> Document:
        name = node["name"]
        return {
            **node,
            "ghost": False,
            "state": "gone",
            "process": self._processes.get(name),
            "since": self._ghost_since.get(name, wall),
            "endpoints": [{**one, "ghost": True} for _, one in self._lost if one["node"] == name],
        }

    def _present(self, node: Document, rows: Rows) -> Document:
        name = node["name"]
        process = process_of(name, node["pid"], rows)
        if process is not None:
            self._processes[name] = process
        return {
            **node,
            "state": "ghost" if node["ghost"] else "running",
            "process": self._processes.get(name),
            "since": self._ghost_since.get(name),
        }

    def _expire(self, rows: Rows, wall: float) -> None:
        by_name = {row["name"]: row for row in rows}
        for name, node in list(self._gone.items()):
            row = by_name.get(str(node["process"]))
            keep_s = GONE_CLEAN_S if _is_clean(row, node["pid"]) else GONE_S
            if wall - node["since"] > keep_s:
                del self._gone[name]

    def _topics(self, topics: list[Document], endpoints: Iterable[Document]) -> list[Document]:
        """With the topics that only nodes that have gone use."""
        known = {topic["name"] for topic in topics}
        lost = dict.fromkeys(one["topic"] for one in endpoints if one["topic"] not in known)
        return topics + [
            {"name": name, "types": self._types.get(name, []), "publishers": 0, "subscriptions": 0}
            for name in lost
        ]


def _key(endpoint: Document) -> tuple[Any, ...]:
    return tuple(endpoint.get(name) for name in ("node", "topic", "direction", "gid"))


def process_of(node: str, pid: int | None, rows: Rows) -> str | None:
    """The name of the process of a node, by its pid, else by the node names in `ps`."""
    for row in rows:
        if pid is not None and row["pid"] == pid:
            return str(row["name"])
    for row in rows:
        if node in (row.get("node_names") or ()):
            return str(row["name"])
    return None


def _is_clean(row: Document | None, pid: int | None) -> bool:
    """Whether a node went without a failure; `row`: its process, if that is one of the run."""
    if row is None:
        return True
    if row["state"] in _ALIVE and row["pid"] == pid:
        return True
    end = row.get("last_exit")
    return end is not None and bool(end["asked"] or end["returncode"] == 0)
