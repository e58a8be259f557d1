"""Which part of a graph is drawn, after rqt_graph's modes and filters."""

from __future__ import annotations

import enum
import re
from dataclasses import dataclass, replace

from launcher.base.errors import UsageError
from launcher.ros.snapshot.ros_graph import DEBUG_TOPICS, Endpoint, TopicGraph, is_hidden


class Mode(enum.Enum):
    NODES = "nodes"  # nodes, connected directly
    ACTIVE = "active"  # topics that have both publishers and subscriptions
    ALL = "all"  # every topic


@dataclass(frozen=True, slots=True, kw_only=True)
class Filter:
    """Selects a part of a graph; patterns are regular expressions for `re.search`."""

    mode: Mode = Mode.ALL
    include: str | None = None
    exclude: str | None = None
    debug: bool = False
    hidden: bool = False

    def check(self) -> None:
        """UsageError if a pattern is not valid."""
        for pattern in (self.include, self.exclude):
            _search(pattern or "", "")

    def apply(self, snapshot: TopicGraph) -> TopicGraph:
        """The selected part; UsageError if a pattern is not valid."""
        nodes = tuple(n for n in snapshot.nodes if self._keeps(n))
        endpoints = tuple(
            e for e in snapshot.endpoints if self._shows(e.topic) and self._keeps(e.node)
        )
        if self.include:
            nodes, endpoints = self._including(nodes, endpoints)
        ghosts = tuple(n for n in snapshot.ghosts if n in nodes)
        kept = replace(snapshot, nodes=nodes, endpoints=endpoints, ghosts=ghosts)
        return kept if self.mode is Mode.ALL else _active(kept)

    def _keeps(self, name: str) -> bool:
        if is_hidden(name) and not self.hidden:
            return False
        return self.exclude is None or not _search(self.exclude, name)

    def _shows(self, topic: str) -> bool:
        return self._keeps(topic) and (self.debug or topic not in DEBUG_TOPICS)

    def _including(
        self, nodes: tuple[str, ...], endpoints: tuple[Endpoint, ...]
    ) -> tuple[tuple[str, ...], tuple[Endpoint, ...]]:
        """Nodes and topics that match, and their neighbours."""
        pattern = self.include or ""
        kept = tuple(e for e in endpoints if _search(pattern, e.node) or _search(pattern, e.topic))
        touched = {e.node for e in kept}
        return tuple(n for n in nodes if n in touched or _search(pattern, n)), kept


def _search(pattern: str, name: str) -> bool:
    try:
        return re.search(pattern, name) is not None
    except re.error as error:
        raise UsageError(f"invalid regular expression '{pattern}': {error}") from None


def _active(snapshot: TopicGraph) -> TopicGraph:
    """Without topics that have only publishers or only subscriptions."""
    sides: dict[str, set[str]] = {}
    for endpoint in snapshot.endpoints:
        sides.setdefault(endpoint.topic, set()).add(endpoint.direction)
    return snapshot.without(topic for topic, found in sides.items() if len(found) == 1)
