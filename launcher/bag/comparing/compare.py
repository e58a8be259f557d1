"""`bag compare`: whether two bags are alike, topic by topic and message by message."""

from __future__ import annotations

from array import array
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from launcher.bag.agreement import difference
from launcher.bag.bag_model import BagError, Message, Span, Topic
from launcher.bag.comparing.field_difference import Rules, first_difference
from launcher.bag.comparing.topic_traits import (
    Difference,
    Tolerances,
    Traits,
    differences,
    traits_of,
)
from launcher.bag.decode import Decoder, decoder
from launcher.bag.reader import Bag
from launcher.bag.topic_course import TopicTimes
from launcher.bag.topic_selection import Selection


@dataclass(frozen=True, slots=True, kw_only=True)
class CompareOptions:
    """`fields` None: contents are not compared. `align` is `start` or `none`."""

    selection: Selection
    tolerances: Tolerances
    fields: Rules | None
    align: str = "start"


@dataclass(slots=True, kw_only=True)
class TopicComparison:
    """A topic in both bags; `compared` is the number of pairs of messages that were."""

    name: str
    a: Traits | None
    b: Traits | None
    differences: list[Difference]
    compared: int = 0


@dataclass(slots=True, kw_only=True)
class Comparison:
    """`shift_ns` is how much later B begins."""

    shift_ns: int
    topics: list[TopicComparison]

    @property
    def alike(self) -> bool:
        return not any(topic.differences for topic in self.topics)


def compare(a: Bag, b: Bag, options: CompareOptions) -> Comparison:
    """Read both bags once, side by side. BagError."""
    shift_ns = b.extent.start_ns - a.extent.start_ns if a.extent.counts and b.extent.counts else 0
    span = Span() if options.align == "start" else _common(a, b)
    sides = _Side(a, options.selection, span), _Side(b, options.selection, span)
    pairs = _Pairs(sides, options.fields)
    origins = (a.extent.start_ns, b.extent.start_ns) if options.align == "start" else (0, 0)
    _read(sides, pairs, origins)
    names = dict.fromkeys((*sides[0].topics, *sides[1].topics))
    topics = []
    for name in sorted(names):
        known = sides[0].traits(name), sides[1].traits(name)
        found = [*differences(*known, options.tolerances), *_mixture(name, sides)]
        if (contents := pairs.found.get(name)) is not None:
            found.append(contents)
        topics.append(
            TopicComparison(
                name=name,
                a=known[0],
                b=known[1],
                differences=found,
                compared=pairs.compared.get(name, 0),
            )
        )
    return Comparison(shift_ns=shift_ns, topics=topics)


def _common(a: Bag, b: Bag) -> Span:
    """The time that both bags have by their clocks; BagError if there is none."""
    start = max(a.extent.start_ns, b.extent.start_ns)
    end = min(a.extent.end_ns, b.extent.end_ns)
    if start > end:
        raise BagError(
            f"{a.path} and {b.path} have no time in common",
            hint="--align start counts times from the start of each",
        )
    return Span(start, end + 1)


def _mixture(name: str, sides: tuple[_Side, _Side]) -> Iterator[Difference]:
    """What is not comparable: other definitions or encodings, and messages that are left out."""
    a, b = (side.topics.get(name) for side in sides)
    if a is not None and b is not None and a.type == b.type:
        both_hashed = a.type_hash and b.type_hash
        if a.serialization != b.serialization:
            yield Difference(kind="encoding", a=a.serialization, b=b.serialization)
        elif not both_hashed and difference(a, b):
            yield Difference(kind="definition", a=a.type, b=b.type)
    left_out = [side.left_out.get(name, 0) for side in sides]
    if any(left_out):
        yield Difference(kind="left out", a=left_out[0], b=left_out[1])


@dataclass(slots=True)
class _Tally:
    """The times of a topic's messages, and how long they took."""

    times_ns: array[int] = field(default_factory=lambda: array("q"))
    latencies_ns: array[int] = field(default_factory=lambda: array("q"))


class _Side:
    """One of the bags, with what has been read of it."""

    def __init__(self, bag: Bag, selection: Selection, span: Span) -> None:
        chosen = [one for one in bag.topics if selection.has(one.name, one.type)]
        self.topics = {topic.name: topic for topic in chosen}
        self.left_out = bag.left_out
        self._tallies = {name: _Tally() for name in self.topics}
        self.messages: Iterator[Message] = bag.messages(self.topics, span)

    def next(self) -> Message | None:
        message = next(self.messages, None)
        if message is not None:
            tally = self._tallies[message.topic]
            tally.times_ns.append(message.log_ns)
            tally.latencies_ns.append(message.log_ns - message.publish_ns)
        return message

    def traits(self, name: str) -> Traits | None:
        if name not in self.topics:
            return None
        tally, times = self._tallies[name], TopicTimes()
        times.add(tally.times_ns)
        return traits_of(self.topics[name], times, tally.latencies_ns)


def _read(sides: tuple[_Side, _Side], pairs: _Pairs, origins: tuple[int, int]) -> None:
    """Both bags at the same pace, so that few messages wait for their counterparts."""
    heads = [side.next() for side in sides]
    while (head_a := heads[0]) is not None or heads[1] is not None:
        head_b = heads[1]
        if head_b is None:
            which = 0
        elif head_a is None:
            which = 1
        else:
            which = int(head_b.log_ns - origins[1] < head_a.log_ns - origins[0])
        message = heads[which]
        assert message is not None
        heads[which] = sides[which].next()
        pairs.add(which, message, other_is_over=heads[1 - which] is None)


class _Pairs:
    """Compares message n of a topic with message n of it in the other bag, up to a difference."""

    def __init__(self, sides: tuple[_Side, _Side], rules: Rules | None) -> None:
        self._rules = rules
        self._topics = sides[0].topics, sides[1].topics
        self._waiting: dict[str, tuple[deque[bytes], deque[bytes]]] = {}
        self._decoders: dict[str, tuple[Decoder, Decoder]] = {}
        self.compared: dict[str, int] = {}
        self.found: dict[str, Difference] = {}
        if rules is not None:
            a, b = self._topics
            shared = (name for name in a if name in b and a[name].type == b[name].type)
            self._waiting = {name: (deque(), deque()) for name in shared}

    def add(self, which: int, message: Message, *, other_is_over: bool) -> None:
        queues = self._waiting.get(message.topic)
        if queues is None:
            return
        if queues[1 - which]:
            other = queues[1 - which].popleft()
            pair = (message.data, other) if which == 0 else (other, message.data)
            self._compare(message.topic, *pair)
        elif not other_is_over:
            queues[which].append(message.data)

    def _compare(self, name: str, a: bytes, b: bytes) -> None:
        index = self.compared[name] = self.compared.get(name, 0) + 1
        if a == b and self._is_same_type(name):
            return
        difference = self._difference(name, a, b, index - 1)
        if difference is not None:
            self.found[name] = difference
            del self._waiting[name]

    def _is_same_type(self, name: str) -> bool:
        a, b = (topics[name] for topics in self._topics)
        return a.type_hash == b.type_hash or not (a.type_hash and b.type_hash)

    def _difference(self, name: str, a: bytes, b: bytes, index: int) -> Difference | None:
        assert self._rules is not None
        try:
            decode_a, decode_b = self._decoders_of(name)
            found = first_difference(decode_a(a), decode_b(b), self._rules)
        except BagError as error:
            if a == b:
                return None
            note = error.message.removeprefix(f"{name}: ")
            return Difference(kind="data", a=len(a), b=len(b), index=index, note=note)
        if found is None:
            return None
        return Difference(kind="field", a=found.a, b=found.b, path=found.path, index=index)

    def _decoders_of(self, name: str) -> tuple[Decoder, Decoder]:
        """A bag without definitions is read with those of the other one."""
        if name not in self._decoders:
            a, b = (topics[name] for topics in self._topics)
            self._decoders[name] = decoder(_defined(a, b)), decoder(_defined(b, a))
        return self._decoders[name]


def _defined(topic: Topic, other: Topic) -> Topic:
    return topic if topic.definition is not None else other


def document(result: Comparison, paths: Mapping[str, str]) -> dict[str, object]:
    """The result as JSON; `paths` are those of `a` and `b`."""
    from dataclasses import asdict

    from launcher.bag.decode import plain

    return {
        **paths,
        "alike": result.alike,
        "shift_ns": result.shift_ns,
        "topics": [
            {
                "name": topic.name,
                "a": None if topic.a is None else topic.a.document(),
                "b": None if topic.b is None else topic.b.document(),
                "compared": topic.compared,
                "differences": [
                    {
                        **asdict(one),
                        "a": plain(one.a),
                        "b": plain(one.b),
                    }
                    for one in topic.differences
                ],
            }
            for topic in result.topics
        ],
    }
