"""Picture: which part of a graph is drawn, after rqt_graph's modes and filters."""

from __future__ import annotations

import enum
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

from launcher.errors import UsageError
from launcher.ros.snapshot.graph import DEBUG_TOPICS, Endpoint, TopicGraph, is_hidden
from launcher.ros.snapshot.qos_matching import mismatched_policy


class Mode(enum.Enum):
    """What is drawn, as rqt_graph names it."""

    NODES = "nodes"  # nodes, connected directly
    ACTIVE = "active"  # topics that have both publishers and subscriptions
    ALL = "all"  # every topic


@dataclass(frozen=True, slots=True, kw_only=True)
class Filter:
    """What is left of a graph; patterns are regular expressions that are searched for."""

    mode: Mode = Mode.ALL
    include: str | None = None
    exclude: str | None = None
    debug: bool = False
    hidden: bool = False

    def check(self) -> None:
        """UsageError if a pattern is none."""
        for pattern in (self.include, self.exclude):
            _search(pattern or "", "")

    def apply(self, snapshot: TopicGraph) -> TopicGraph:
        """The part that is drawn; UsageError if a pattern is none."""
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
        """Nodes and topics that match, with what they are connected to."""
        pattern = self.include or ""
        kept = tuple(e for e in endpoints if _search(pattern, e.node) or _search(pattern, e.topic))
        touched = {e.node for e in kept}
        return tuple(n for n in nodes if n in touched or _search(pattern, n)), kept


def _search(pattern: str, name: str) -> bool:
    try:
        return re.search(pattern, name) is not None
    except re.error as error:
        raise UsageError(f"'{pattern}' is no regular expression: {error}") from None


def _active(snapshot: TopicGraph) -> TopicGraph:
    """Without the topics that have only one side."""
    sides: dict[str, set[str]] = {}
    for endpoint in snapshot.endpoints:
        sides.setdefault(endpoint.topic, set()).add(endpoint.direction)
    return snapshot.without(topic for topic, found in sides.items() if len(found) == 1)


@dataclass(frozen=True, slots=True, kw_only=True, order=True)
class Link:
    """A publisher's node, a subscription's node, and the topic between; `fault` is a policy."""

    source: str
    target: str
    topic: str
    fault: str | None = None


def links(endpoints: Iterable[Endpoint]) -> list[Link]:
    """Every pair of nodes that share a topic, sorted. A pair that works hides one that does not."""
    known = sorted(set(endpoints))
    found: dict[tuple[str, str, str], str | None] = {}
    for publisher in (e for e in known if e.is_publisher):
        for subscription in (e for e in known if not e.is_publisher):
            if publisher.topic == subscription.topic:
                key = (publisher.node, subscription.node, publisher.topic)
                fault = mismatched_policy(publisher, subscription)
                found[key] = None if found.get(key, fault) is None else fault
    return [
        Link(source=source, target=target, topic=topic, fault=fault)
        for (source, target, topic), fault in sorted(found.items())
    ]


def namespace_of(name: str) -> str:
    """`/site/east` of `/site/east/listener`; empty at the top."""
    return name.rpartition("/")[0]
