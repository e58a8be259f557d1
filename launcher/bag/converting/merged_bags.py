"""Several bags as one, with some of their topics and under other names."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from launcher.bag.agreement import difference
from launcher.bag.bag_model import BagError, Message, Span, Topic, distinct
from launcher.bag.reader import Bag
from launcher.bag.topic_selection import Selection
from launcher.base.text import did_you_mean

# The type with its definition and hash, where these are missing; BagError if it is not known.
Complete = Callable[[Topic], Topic]


class Merged:
    """The selected topics of bags; those of one name are one topic.

    `remap` gives new names; selections are of the old ones. BagError if nothing is selected, or if
    types differ. `spans` are the parts of the bags that are read, None: all.
    """

    def __init__(
        self,
        bags: Sequence[Bag],
        selection: Selection,
        remap: Mapping[str, str] | None = None,
        complete: Complete = lambda topic: topic,
        spans: Sequence[Span] | None = None,
    ) -> None:
        self.bags = bags
        self._spans = spans or [Span()] * len(bags)
        self._remap = dict(remap or {})
        self._check_names((*selection.topics, *self._remap))
        self._chosen: list[dict[str, str]] = []  # of each bag, old names to new ones
        self._origins: dict[str, str] = {}
        found: dict[str, Topic] = {}
        for bag in bags:
            topics = [topic for topic in bag.topics if selection.has(topic.name, topic.type)]
            self._chosen.append({one.name: self._remap.get(one.name, one.name) for one in topics})
            for topic in topics:
                self._add(found, replace(topic, name=self._chosen[-1][topic.name]), bag)
        self.topics = [complete(topic) for topic in found.values()]
        if not self.topics:
            known = ", ".join(self._known()) or "none"
            raise BagError("no topic is selected", hint=f"topics of the bag: {known}")

    def _known(self) -> list[str]:
        return list(dict.fromkeys(topic.name for bag in self.bags for topic in bag.topics))

    def _check_names(self, names: Iterable[str]) -> None:
        known = self._known()
        for name in names:
            if name not in known:
                listed = f"topics: {', '.join(known)}" if known else None
                where = " or ".join(bag.path for bag in self.bags)
                raise BagError(
                    f"there is no topic {name} in {where}", hint=did_you_mean(name, known) or listed
                )

    def _add(self, found: dict[str, Topic], topic: Topic, bag: Bag) -> None:
        known = found.get(topic.name)
        if known is None:
            found[topic.name] = topic
            self._origins[topic.name] = bag.path
            return
        origin = self._origins[topic.name]
        hint = f"--exclude-topics {topic.name} leaves it out; --remap OLD:=NEW renames topics"
        if known.type != topic.type:
            raise BagError(
                f"{topic.name} is {known.type} in {origin} and {topic.type} in {bag.path}",
                hint=hint,
            )
        if known.serialization != topic.serialization:
            raise BagError(
                f"{topic.name} is in '{known.serialization}' in {origin} and in "
                f"'{topic.serialization}' in {bag.path}",
                hint=hint,
            )
        if difference(known, topic):
            raise BagError(
                f"{topic.name}: {topic.type} is not defined in the same way in {origin} and "
                f"in {bag.path}",
                hint=hint,
            )
        found[topic.name] = replace(
            known,
            definition=known.definition or topic.definition,
            type_hash=known.type_hash or topic.type_hash,
            qos=distinct([*known.qos, *topic.qos]),
        )

    def leave_out(self, name: str) -> None:
        """Without this topic from now on; it is one of `topics`."""
        self.topics = [topic for topic in self.topics if topic.name != name]
        for names in self._chosen:
            for old in [old for old, new in names.items() if new == name]:
                del names[old]

    @property
    def start_ns(self) -> int:
        """The time of the first message of all bags."""
        return min((bag.extent.start_ns for bag in self.bags if bag.extent.counts), default=0)

    def messages(self, span: Span, topics: frozenset[str] | None = None) -> Iterator[Message]:
        """The messages of these topics (None: all) in the order of their times. BagError."""
        streams = [
            self._of_bag(bag, names, _both(part, span), topics)
            for bag, names, part in zip(self.bags, self._chosen, self._spans, strict=True)
        ]
        if len(streams) == 1:
            return streams[0]
        return heapq.merge(*streams, key=lambda message: message.log_ns)

    def _of_bag(
        self, bag: Bag, names: Mapping[str, str], span: Span, topics: frozenset[str] | None
    ) -> Iterator[Message]:
        wanted = [old for old, new in names.items() if topics is None or new in topics]
        for message in bag.messages(wanted, span):
            new = names[message.topic]
            yield message if new == message.topic else message._replace(topic=new)


def _both(one: Span, other: Span) -> Span:
    """What is in both."""
    starts = [span.start_ns for span in (one, other) if span.start_ns is not None]
    ends = [span.end_ns for span in (one, other) if span.end_ns is not None]
    return Span(max(starts, default=None), min(ends, default=None))
