"""Subscribes to the selected topics, now and as they appear, and passes on what they receive.

Nothing is deserialized. The middleware stamps each message on arrival, so taking them in bursts
loses no time.
"""

from __future__ import annotations

import functools
import struct
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from launcher.bag.bag_model import CDR, Definition, Message, Qos, Topic, distinct
from launcher.bag.ros import bag_qos
from launcher.bag.ros.sinks import FileSink, Ring
from launcher.bag.topic_selection import Selection
from launcher.base.ros_errors import VerbError
from launcher.ros.discovery.graph_changes import GraphChanges
from launcher.ros.messages.classes import with_library
from launcher.ros.messages.interfaces import load_message
from launcher.ros.messages.message_schema import rihs_hash, schema_text
from launcher.ros.snapshot.ros_graph import Direction, Endpoint, EndpointInfo
from launcher.ros.topics import qos
from launcher.ros.topics.fitted import Fitted
from launcher.ros.topics.raw import RawMessage, RawTaker, subscribed

if TYPE_CHECKING:
    from launcher.ros.discovery.observer import Observer

PERIOD_S = 0.01
_REFIT_S = 0.1  # from one look at the publishers of recorded topics to the next, if any changed
_FORGET_S = 1.0
REMEMBER_S = 60.0
_BURST = 500  # messages of one topic, then the others have their turn
_STAMP = struct.Struct("<4xiI")  # of a serialized rosgraph_msgs/msg/Clock


@dataclass(frozen=True, slots=True, kw_only=True)
class RecorderOptions:
    """`overrides` are policies of topics; `poll_s` is the time from one look for new topics to the
    next, `None` is a single look. Publishers are remembered for `remember_s` after they have gone.

    `static` topics with their types are subscribed to at once. `repeat` are topics with the number
    of messages that each file begins with, `repeat_latched` is that of all TRANSIENT_LOCAL ones.
    """

    selection: Selection
    overrides: Mapping[str, Qos] = field(default_factory=dict)
    poll_s: float | None = 0.1
    use_sim_time: bool = False
    include_unpublished: bool = False
    ignore_leaves: bool = False  # topics without a subscription
    static: Mapping[str, str] = field(default_factory=dict)
    repeat: Mapping[str, int] = field(default_factory=dict)
    repeat_latched: int = 0
    remember_s: float = REMEMBER_S


@dataclass(slots=True)
class Recorded:
    """A topic that is recorded. `lost` messages were published and never taken."""

    topic: Topic
    fitted: Fitted
    count: int = 0
    lost: int = 0
    dropped: int = 0

    @property
    def publishers(self) -> set[bytes]:
        """Those of the last look."""
        return set(map(_gid, self.fitted.publishers))


class Recorder:
    """Records into a sink; `notes` is called with a sentence for users.

    Call `poll` every `PERIOD_S`, and at once while it `is_behind`.
    """

    def __init__(
        self,
        observer: Observer,
        options: RecorderOptions,
        sink: FileSink | Ring,
        notes: Callable[[str], None],
    ) -> None:
        self.topics: dict[str, Recorded] = {}
        self.nodes: dict[bytes, str] = {}  # id of a publisher -> full name of its node
        self.bytes = 0
        self.paused = False
        self.discovers = True  # looks for new topics
        self.is_taking = False
        self.is_behind = False  # some topic had more than its turn took
        # Called with each message, also while it pauses: topic, time of publishing, of receiving.
        self.watch: Callable[[str, int, int], None] | None = None
        self._observer = observer
        self._options = options
        self._sink = sink
        self._notes = notes
        self._taker = RawTaker()
        self._refused: set[tuple[str, str]] = set()
        self._gone_s: dict[bytes, float] = {}  # publishers, and since when
        self._changes = GraphChanges(observer.node)
        self._next_look_s = self._next_refit_s = self._next_forget_s = 0.0
        self._sim_ns: int | None = None
        self._clock: Any = None
        if options.use_sim_time:
            kind = with_library(load_message("rosgraph_msgs/msg/Clock"))
            self._clock = subscribed(observer.node, kind, "/clock", qos.listening([])[0])

    @property
    def published(self) -> dict[str, str]:
        """What is recorded, and was published, with its type."""
        topics = self.topics.values()
        return {
            one.topic.name: one.topic.type
            for one in topics
            if one.count or one.publishers or one.topic.name not in self._options.static
        }

    @property
    def count(self) -> int:
        return sum(one.count for one in self.topics.values())

    @property
    def lost(self) -> int:
        return sum(one.lost + one.dropped for one in self.topics.values())

    def poll(self) -> int:
        """Look for new topics if it is time, and take what has arrived; how many were taken."""
        now = time.monotonic()
        if self.discovers and now >= self._next_look_s:
            self._look()
            poll_s = self._options.poll_s
            self.discovers = poll_s is not None
            self._next_look_s = time.monotonic() + (poll_s or 0.0)
        if now >= self._next_refit_s:
            if self._changes.happened():
                for recorded in list(self.topics.values()):
                    self._refit(recorded)
            self._next_refit_s = time.monotonic() + _REFIT_S
        if now >= self._next_forget_s:
            self._forget_gone(now)
            self._next_forget_s = time.monotonic() + _FORGET_S
        return self.take(_BURST)

    def _look(self) -> None:
        selection = self._options.selection
        for name, type_name in self._options.static.items():
            if name not in self.topics:
                self._begin(name, type_name)
        for name, types in self._observer.topic_types().items():
            if name in self.topics:
                continue
            if len(types) > 1 and any(selection.has(name, one) for one in types):
                self._refuse(name, f"{name} has several types ({', '.join(types)})", None)
            elif types and selection.has(name, types[0]):
                self._begin(name, types[0])

    def _begin(self, name: str, type_name: str) -> None:
        infos = self._publishers(name, type_name)
        is_static = name in self._options.static
        if not infos and not self._options.include_unpublished and not is_static:
            return
        if (name, type_name) in self._refused or self._is_ignored_leaf(name):
            return
        try:
            topic = Topic(
                name=name,
                type=type_name,
                serialization=CDR,
                qos=distinct(map(bag_qos.offered_by, infos)),
                type_hash=rihs_hash(type_name),
                definition=Definition(text=schema_text(type_name)),
            )
            fitted = self._fitted(name, type_name)
            fitted.fit([info.endpoint() for info in infos])
            if is_static:
                self._hold(name, fitted)
        except VerbError as error:
            self._refused.add((name, type_name))
            self._refuse(name, f"{type_name}: {error.message}", error.hint)
            return
        self._sink.add_topic(topic)
        if depth := self._repeated(name, infos):
            self._sink.repeat(name, depth)
        self._learn(infos)
        self.topics[name] = Recorded(topic, fitted)

    def _publishers(self, name: str, type_name: str) -> list[EndpointInfo]:
        """Those with this type; others of the topic are named."""
        found = []
        for info in self._observer.infos(name, Direction.PUBLISHER):
            kind = info.endpoint().type
            if kind == type_name:
                found.append(info)
            else:
                self._refuse(f"{name} with {kind}", f"it is recorded with {type_name}", None)
        return found

    def _is_ignored_leaf(self, name: str) -> bool:
        return self._options.ignore_leaves and not self._observer.infos(
            name, Direction.SUBSCRIPTION
        )

    def _hold(self, name: str, fitted: Fitted) -> None:
        """Subscribe without a publisher, to be there when it comes."""
        if fitted.profile is None:
            reliable = {"reliability": "reliable"}  # nothing of such a publisher is lost
            profile = bag_qos.changed(qos.listening([])[0], reliable)
            override = self._options.overrides.get(name)
            fitted.use(bag_qos.changed(profile, override) if override else profile)

    def _repeated(self, name: str, infos: Sequence[EndpointInfo]) -> int:
        """How many messages of a topic each file begins with."""
        if name in self._options.repeat or not self._options.repeat_latched:
            return self._options.repeat.get(name, 0)
        if not infos:
            self._notes(
                f"{name} has no publisher yet, and is not repeated\n"
                f"hint: --repeat-transient-local {name} repeats it in any case"
            )
        latched = any(one.durability.upper() == "TRANSIENT_LOCAL" for one in infos)
        return self._options.repeat_latched if latched else 0

    def _learn(self, infos: list[EndpointInfo]) -> None:
        for info in infos:
            if info.node:
                self.nodes[_gid(info.gid)] = info.node

    def _forget_gone(self, now: float) -> None:
        """Forget publishers some time after they have gone: nodes restart, and this goes on."""
        topics = self.topics.values()
        known = self.nodes.keys() | {gid for one in topics for gid in one.fitted.numbers.last}
        gone = known.difference(*(one.publishers for one in topics))
        self._gone_s = {publisher: self._gone_s.get(publisher, now) for publisher in gone}
        for publisher, gone_s in self._gone_s.items():
            if now - gone_s > self._options.remember_s:
                self.nodes.pop(publisher, None)
                for one in topics:
                    one.fitted.numbers.last.pop(publisher, None)

    def _refuse(self, name: str, reason: str, hint: str | None) -> None:
        """Say once why a topic is not recorded."""
        if (name, reason) not in self._refused:
            self._refused.add((name, reason))
            note = f"{name} is not recorded: {reason}"
            self._notes(f"{note}\nhint: {hint}" if hint else note)

    def _fitted(self, name: str, type_name: str) -> Fitted:
        kind, override = with_library(load_message(type_name)), self._options.overrides.get(name)

        def fitting(publishers: Sequence[Endpoint]) -> Any:
            profile, _ = qos.listening(publishers)
            return bag_qos.changed(profile, override) if override else profile

        create = functools.partial(subscribed, self._observer.node, kind, name)
        return Fitted(self._observer.node, self._taker, create, fitting)

    def _refit(self, recorded: Recorded) -> None:
        infos = self._publishers(recorded.topic.name, recorded.topic.type)
        self._learn(infos)
        before = recorded.fitted.publishers
        recorded.fitted.fit([info.endpoint() for info in infos])
        if recorded.topic.name in self._options.static:
            self._hold(recorded.topic.name, recorded.fitted)
        if recorded.fitted.publishers - before:
            self._add_qos(recorded, infos)

    def _add_qos(self, recorded: Recorded, infos: list[EndpointInfo]) -> None:
        """Note what publishers offer, once: those that have restarted offer the same."""
        profiles = distinct([*recorded.topic.qos, *map(bag_qos.offered_by, infos)])
        if len(profiles) > len(recorded.topic.qos):
            recorded.topic = replace(recorded.topic, qos=profiles)
            self._sink.set_qos(recorded.topic.name, profiles)

    def take(self, most: int = qos.LISTEN_DEPTH) -> int:
        """Take what has arrived, at most so many messages of each topic."""
        if self._clock is not None:
            self._read_clock()
        self.is_taking = True
        numbers = [self._take_from(one, most) for one in self.topics.values()]
        self.is_behind = max(numbers, default=0) >= most
        self.is_taking = False
        return sum(numbers)

    def now_ns(self) -> int:
        """The time of messages that are received now; 0 before the first /clock."""
        if self._options.use_sim_time:
            return self._sim_ns or 0
        return time.time_ns()

    def _read_clock(self) -> None:
        handle = self._clock.handle
        with handle:
            while (raw := self._taker.take(handle)) is not None:
                seconds, nanoseconds = _STAMP.unpack_from(raw.data)
                self._sim_ns = max(seconds * 10**9 + nanoseconds, 0)

    def _take_from(self, recorded: Recorded, most: int) -> int:
        count = 0
        for raw, lost in recorded.fitted.take(most):
            count += 1
            self._pass_on(recorded, raw, lost)
        return count

    def _pass_on(self, recorded: Recorded, raw: RawMessage, lost: int) -> None:
        if not self.paused:
            recorded.lost += lost
        source_ns = max(raw.source_ns, 0)  # bags have no time before 1970
        log_ns: int | None = raw.received_ns
        if self._options.use_sim_time:
            log_ns = self._sim_ns
        if self.watch is not None and log_ns is not None:
            self.watch(recorded.topic.name, source_ns, log_ns)
        if self.paused or log_ns is None:  # there is no time before the first /clock
            return
        message = Message(recorded.topic.name, log_ns, source_ns, raw.sequence, raw.data)
        if self._sink.put(message, raw.publisher):
            recorded.count += 1
            self.bytes += len(raw.data)
        else:
            recorded.dropped += 1

    def close(self) -> None:
        for recorded in self.topics.values():
            recorded.fitted.close()
        if self._clock is not None:
            self._observer.node.destroy_subscription(self._clock)
        self._changes.close()
        self._taker.close()


def _gid(dotted: str) -> bytes:
    return bytes.fromhex(dotted.replace(".", ""))
