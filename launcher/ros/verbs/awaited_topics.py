"""Topics of a command line: what is there at the start, and what is published later."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

from launcher.base.model.ros_names import full_name
from launcher.base.ros_errors import VerbError, did_you_mean
from launcher.posix.domains import why_empty
from launcher.ros.discovery.completeness import settle
from launcher.ros.snapshot.ros_graph import Direction, GraphSnapshot
from launcher.ros.topics import qos
from launcher.ros.topics.listener import Listener, TopicTarget, full_topic
from launcher.ros.topics.qos import QosOptions
from launcher.ros.verb import say, warn

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer

_PERIOD_S = 0.004
_STEADY_S = 0.06  # endpoints of one participant arrive together
_INTRODUCTION_S = 0.3
_AWAIT_PERIOD_S = 0.1  # after it, all endpoints of a participant are known


def are_published(names: Iterable[str]) -> Callable[[GraphSnapshot], bool]:
    """Checks whether a graph has publishers of all these topics."""
    full = list(map(full_name, names))
    return lambda graph: all(graph.on(name, Direction.PUBLISHER) for name in full)


def target_in(
    graph: GraphSnapshot | Observer, full: str, type_name: str | None = None
) -> TopicTarget | None:
    """The topic as the graph has it; None if its type is unknown.

    With a type the topic need not exist yet. VerbError if there are several types.
    """
    types = graph.topic_types().get(full, [])
    if type_name is None and len(types) > 1:
        raise VerbError(
            f"Cannot echo topic '{full}', as it contains more than one type: [{', '.join(types)}]",
            hint="name one of them after the topic",
        )
    if type_name is None and not types:
        return None
    publishers = tuple(e for e in graph.endpoints(full) if e.is_publisher)
    return TopicTarget(name=full, type=type_name or types[0], publishers=publishers)


class TopicSubscriber:
    """Subscribes with the QoS of the command line, or as it fits the publishers."""

    def __init__(
        self,
        observer: Observer,
        listener: Listener,
        chosen: QosOptions,
        spin_time_s: float,
        *,
        json: bool,
    ) -> None:
        self.observer = observer
        self.json = json
        self._listener = listener
        self._chosen = chosen
        self._spin_time_s = spin_time_s

    def subscribe_now(self, name: str, type_name: str | None) -> None:
        """Subscribe; VerbError with the text of ros2cli if the type is unknown."""
        target = self.first_target(name, type_name)
        if target is None:
            say(_unpublished(name), json=self.json)
            raise VerbError(
                "Could not determine the type for the passed topic",
                hint=_hint(self.observer, name),
            )
        self.subscribe(target)

    def first_target(self, name: str, type_name: str | None = None) -> TopicTarget | None:
        """The topic as soon as its publishers are known; None if it has none and no type."""
        full = full_topic(name)
        if (graph := self.observer.prefetched_graph()) is None:
            self._await_publishers(full)
            return target_in(self.observer, full, type_name)
        if target := target_in(graph, full, type_name):
            self._await_introduction(target)
        return target

    def _await_introduction(self, target: TopicTarget) -> None:
        """Return when rclpy has discovered the publishers of a target that was prefetched, or soon.

        A publisher may publish at once when it discovers our subscription, and we have to know it
        then.
        """
        deadline = time.monotonic() + _INTRODUCTION_S
        while time.monotonic() < deadline:
            known = self.observer.infos(target.name, Direction.PUBLISHER)
            if len(known) >= len(target.publishers):
                return
            time.sleep(_PERIOD_S)

    def _await_publishers(self, full: str) -> None:
        """Return when the publishers have been the same for a moment, or the graph is settled."""
        last, changed = 0, time.monotonic()

        def steady() -> bool:
            nonlocal last, changed
            infos = self.observer.infos(full, Direction.PUBLISHER)
            if len(infos) != last or not all(info.node for info in infos):
                last, changed = len(infos), time.monotonic()
            return bool(infos) and time.monotonic() - changed > _STEADY_S

        settle(self.observer, self._spin_time_s, enough=steady)

    def subscribe(self, target: TopicTarget) -> None:
        profile, notes = qos.listening(target.publishers)
        if self._chosen != QosOptions():
            self._listener.subscribe(target, qos.from_options(self._chosen, profile))
            return
        for note in notes:
            say(note, json=self.json)
        self._listener.subscribe(target)


class AwaitedTopics:
    """Subscribes to topics now, and to unpublished ones as soon as they are published.

    `found` is called for each, or `failed` if its type is not usable.
    """

    def __init__(
        self,
        subscriber: TopicSubscriber,
        names: Sequence[str],
        found: Callable[[TopicTarget], None],
        failed: Callable[[str, VerbError], None],
    ) -> None:
        self._subscriber = subscriber
        self._found = found
        self._failed = failed
        self._missing: dict[str, TopicTarget | None] = {}
        for name in names:
            full_topic(name)  # VerbError
            try:
                target = subscriber.first_target(name)
            except VerbError as error:
                failed(name, error)
                continue
            if target is None:
                self._miss(name)
            else:
                self._take(name, target)
        self._next_check = time.monotonic() + _AWAIT_PERIOD_S

    def _miss(self, name: str) -> None:
        self._missing[name] = None
        say(_unpublished(name), json=self._subscriber.json)
        if hint := _hint(self._subscriber.observer, name):
            warn(f"hint: {hint}")

    def _take(self, name: str, target: TopicTarget) -> None:
        try:
            self._subscriber.subscribe(target)
        except VerbError as error:
            self._failed(name, error)
        else:
            self._found(target)

    def poll(self) -> None:
        """Subscribe to missing topics that are published now; checks at most ten times a second."""
        if not self._missing or time.monotonic() < self._next_check:
            return
        for name, before in list(self._missing.items()):
            found = target_in(self._subscriber.observer, full_topic(name))
            target = self._missing[name] = found
            if target is not None and target == before:
                del self._missing[name]
                self._take(name, target)
        self._next_check = time.monotonic() + _AWAIT_PERIOD_S


def _hint(observer: Observer, name: str) -> str | None:
    """What to do about an unpublished topic."""
    graph = observer.prefetched_graph() or observer.graph_snapshot()
    return did_you_mean(name, graph.topic_types()) if graph.nodes else why_empty(observer.domain_id)


def _unpublished(name: str) -> str:
    return f"WARNING: topic [{name}] does not appear to be published yet"
