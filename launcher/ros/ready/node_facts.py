"""Facts that need a node of ours: messages, answers of services, and lifecycle states."""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from rclpy.executors import SingleThreadedExecutor
from rclpy.subscription import Subscription

from launcher.base.errors import LauncherError
from launcher.ros.discovery.prefetch import announce, own_ports
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.from_yaml import Stamp, fill, stamp_all
from launcher.ros.messages.interfaces import full_type, load
from launcher.ros.ready.graph_conditions import Seen, WatchedFact
from launcher.ros.topics.listener import Listener, TopicTarget

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer
    from launcher.ros.discovery.participant import Participant
    from launcher.ros.ready.views import GraphView

_ANSWER_S = 2.0  # then the call is repeated: a node may not have known our client yet
_INTRODUCE_S = 0.2
_STATE_S = 0.2  # from one question for a state to the next


class Calls:
    """What an observer's node receives, as long as somebody waits for it."""

    def __init__(self, observer: Observer) -> None:
        self.observer = observer
        self._executor = _Answers(context=observer.context)
        self._executor.add_node(observer.node)
        self._begun: dict[int, Receiving | Calling] = {}

    @property
    def is_busy(self) -> bool:
        """Whether a message or an answer may come."""
        return bool(self._begun)

    def look(self, number: int, watched: WatchedFact, view: GraphView) -> Seen:
        """Whether a fact holds whose part of the graph is there."""
        if number not in self._begun:
            kind = Receiving if watched.fact.kind == "message" else Calling
            self._begun[number] = kind(self.observer, watched)
        try:
            return self._begun[number].look(view)
        except LauncherError as error:
            return Seen(False, error.message)

    def forget(self, number: int) -> None:
        if number in self._begun:
            self._begun.pop(number).close()

    def spin(self) -> None:
        """Take the answers that have arrived."""
        if self.is_busy:
            self._executor.spin_once(timeout_sec=0)


class _Answers(SingleThreadedExecutor):  # type: ignore[misc]
    """Leaves messages to `Listener.take`: those that it took itself would be lost."""

    def can_execute(self, entity: object) -> bool:
        return not isinstance(entity, Subscription) and bool(super().can_execute(entity))


class Receiving:
    """A subscription that connects to all publishers of a topic."""

    def __init__(self, observer: Observer, watched: WatchedFact) -> None:
        self._observer = observer
        self._fact = watched.fact
        self._listener: Listener | None = None

    def look(self, view: GraphView) -> Seen:
        topic = self._fact.subject
        publishers = view.publishers(topic)
        types = sorted({one.type for one in publishers})
        wanted = self._fact.type or types[0]
        if wanted not in types or (self._fact.type is None and len(types) > 1):
            return Seen(False, f"{topic} has the type {', '.join(types)}")
        if self._listener is None:
            self._listener = Listener(self._observer, raw=True)
            self._listener.subscribe(
                TopicTarget(name=topic, type=full_type(wanted), publishers=publishers)
            )
        self._listener.fit(topic, publishers)
        return Seen(bool(self._listener.take()), f"no message on {topic}")

    def close(self) -> None:
        if self._listener is not None:
            self._listener.close()


class Calling:
    """Calls a service until it answers; of a lifecycle node, until the state is the wanted one."""

    def __init__(self, observer: Observer, watched: WatchedFact) -> None:
        self._node = observer.node
        fact = self._fact = watched.fact
        self._is_state = fact.kind == "lifecycle"
        self.name = f"{fact.node}/get_state" if self._is_state else fact.subject
        self._client: Any = None
        self._request: Any = None
        self._stamps: list[Stamp] = []
        self._future: Any = None
        self._asked_s = 0.0
        self._text = f"service {self.name} does not answer"

    def look(self, view: GraphView) -> Seen:
        if self._client is None:
            self._make(self._fact.type or view.service_types(self.name)[0])
        now = time.monotonic()
        if self._future is not None and self._future.done():
            seen = self._answered(self._future.result())
            self._future = None
            if seen.holds:
                return seen
            self._text = seen.text
        is_lost = self._future is not None and now - self._asked_s > _ANSWER_S
        is_due = self._future is None and now - self._asked_s > _STATE_S
        if (is_lost or is_due) and self._client.service_is_ready():
            if is_lost:
                self._client.remove_pending_request(self._future)
            stamp_all(self._stamps, self._node.get_clock().now().to_msg())
            self._future, self._asked_s = self._client.call_async(self._request), now
        return Seen(False, self._text)

    def _make(self, type_name: str) -> None:
        kind = with_library(load(type_name, "srv", "The passed service type is invalid"))
        self._request = kind.Request()
        self._stamps = fill(self._request, dict(self._fact.request or {}))
        self._client = self._node.create_client(kind, self.name)

    def _answered(self, answer: Any) -> Seen:
        if not self._is_state:
            return Seen(True)
        state = answer.current_state.label
        return Seen(state == self._fact.subject, f"its lifecycle state is {state}")

    def close(self) -> None:
        if self._client is not None:
            self._node.destroy_client(self._client)


class Introductions:
    """Announces participants that the follower has discovered to our node of rclpy.

    Two participants that start at the same time lose each other's first announcements, and the next
    come up to 3 s later (see `discovery.prefetch`). What the follower has received is repeated to
    our own participant, which then announces itself to the other one. Call `introduce` regularly.
    """

    def __init__(self, observer: Observer) -> None:
        self._observer = observer
        self._next_s = 0.0
        self._ports = own_ports(observer.domain_id)

    def introduce(self, peers: Iterable[Participant]) -> None:
        """Repeat the announcements of those that our node does not know."""
        now = time.monotonic()
        if now < self._next_s:
            return
        self._next_s = now + _INTRODUCE_S
        known = self._observer.participants()
        if unknown := [peer for peer in peers if peer.prefix not in known]:
            announce(self._ports, unknown)
