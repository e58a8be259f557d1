"""What a ROS graph has at one moment, as far as clients are concerned."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from launcher.base.ros_errors import VerbError
from launcher.ros.discovery.observer import Observer
from launcher.ros.snapshot.ros_graph import is_hidden

_ALWAYS = "/parameter_events"  # our own node has it as well


@dataclass(frozen=True, slots=True, kw_only=True)
class TopicChoice:
    """Which topics are shown."""

    topics: str | None = None
    exclude: str | None = None
    hidden: bool = False

    def check(self) -> None:
        """VerbError for a bad pattern."""
        for flag, pattern in (("--topics", self.topics), ("--exclude", self.exclude)):
            try:
                re.compile(pattern or "")
            except re.error as error:
                raise VerbError(f"{flag}: '{pattern}' is no regular expression: {error}") from None

    def has(self, topic: str) -> bool:
        return (
            (self.hidden or not is_hidden(topic))
            and (self.topics is None or re.search(self.topics, topic) is not None)
            and (self.exclude is None or re.search(self.exclude, topic) is None)
        )


Names = dict[str, tuple[str, ...]]  # topic or service -> nodes


@dataclass(frozen=True, slots=True, kw_only=True)
class Connections:
    """The nodes that publish, subscribe and serve, as far as their names are known."""

    published: Names = field(default_factory=dict)
    subscribed: Names = field(default_factory=dict)
    services: Names = field(default_factory=dict)

    def update_from(self, before: Connections) -> dict[str, Any] | None:
        """The fields of a connectionGraphUpdate that leads here; None without a difference."""
        topics = before.published.keys() | before.subscribed.keys()
        gone = topics - self.published.keys() - self.subscribed.keys()
        update = {
            "publishedTopics": _changed(self.published, before.published, gone, "publisherIds"),
            "subscribedTopics": _changed(self.subscribed, before.subscribed, gone, "subscriberIds"),
            "advertisedServices": _changed(
                self.services, before.services, before.services.keys(), "providerIds"
            ),
            "removedTopics": sorted(gone),
            "removedServices": sorted(before.services.keys() - self.services.keys()),
        }
        return update if any(update.values()) else None


def _changed(now: Names, before: Names, removed: Iterable[str], ids: str) -> list[dict[str, Any]]:
    """A topic that has lost its last publisher, but not all, gets an empty list."""
    emptied = dict.fromkeys(before.keys() - now.keys() - set(removed), ())
    changed = {name: nodes for name, nodes in now.items() if before.get(name) != nodes}
    return [{"name": name, ids: list(nodes)} for name, nodes in sorted((emptied | changed).items())]


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """Topics and services with their types, and the connections if a client requests them."""

    topics: Mapping[str, tuple[str, ...]]
    services: Mapping[str, str]
    connections: Connections | None = None


def look(
    observer: Observer, choice: TopicChoice, own_topics: Iterable[str], *, with_connections: bool
) -> Look:
    """`own_topics` are those with subscriptions of ours: they exist only if others have them."""
    own, ghosts = set(own_topics), set(observer.ghosts())
    topics = {}
    for name, types in observer.topic_types().items():
        is_certain = name == _ALWAYS or not (name in own or ghosts)
        if choice.has(name) and (
            is_certain or {one.node for one in observer.endpoints(name)} - ghosts
        ):
            topics[name] = tuple(types)
    providers: dict[str, list[str]] = {}
    services: dict[str, str] = {}
    for node in sorted(set(observer.node_names()) - ghosts):
        for name, types in observer.services_of(node):
            if choice.hidden or not is_hidden(name):
                providers.setdefault(name, []).append(node)
                services[name] = types[0]
    return Look(
        topics=dict(sorted(topics.items())),
        services=dict(sorted(services.items())),
        connections=_connections(observer, topics, providers, ghosts) if with_connections else None,
    )


def _connections(
    observer: Observer,
    topics: Iterable[str],
    providers: Mapping[str, list[str]],
    ghosts: Collection[str],
) -> Connections:
    published: dict[str, set[str]] = {}
    subscribed: dict[str, set[str]] = {}
    for topic in topics:
        for endpoint in observer.endpoints(topic):
            # the name of a node arrives after its endpoints
            if endpoint.node in ghosts or not endpoint.has_name:
                continue
            side = published if endpoint.is_publisher else subscribed
            side.setdefault(topic, set()).add(endpoint.node)
    return Connections(
        published=_sorted(published), subscribed=_sorted(subscribed), services=_sorted(providers)
    )


def _sorted(names: Mapping[str, Iterable[str]]) -> Names:
    return {name: tuple(sorted(set(nodes))) for name, nodes in sorted(names.items())}
