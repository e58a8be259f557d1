"""What a bag consists of."""

from __future__ import annotations

import itertools
from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from launcher.base.errors import LauncherError

CDR = "cdr"
ROS2_MSG = "ros2msg"
LAST_NS = 2**63 - 1  # the last time that ROS has room for, in the year 2262

# A QoS profile as in `metadata.yaml`: policies in lower case, times as {"sec": .., "nsec": ..}.
Qos = Mapping[str, Any]

# Times of messages (`log_ns`), by their topics, and before them a time: none of the blocks that
# follow has an earlier one.
TimesBlock = tuple[int, dict[str, "array[int]"]]
_BLOCK = 10_000


def time_blocks(times: Iterable[tuple[str, int]]) -> Iterator[TimesBlock]:
    """Of topics with sorted times."""
    left = iter(times)
    while block := list(itertools.islice(left, _BLOCK)):
        found: dict[str, array[int]] = {}
        for topic, time_ns in block:
            found.setdefault(topic, array("q")).append(time_ns)
        yield block[-1][1], found


@dataclass(frozen=True, slots=True, kw_only=True)
class Definition:
    """The text of a message type with all that it needs, in the language `encoding`."""

    text: str
    encoding: str = ROS2_MSG


@dataclass(frozen=True, slots=True, kw_only=True)
class Topic:
    """A topic of a bag; `type_hash` (RIHS01) and `definition` may be unknown."""

    name: str
    type: str
    serialization: str = CDR
    qos: Sequence[Qos] = ()
    type_hash: str = ""
    definition: Definition | None = field(default=None, compare=False)


class ChannelTopic(NamedTuple):
    """A topic as one channel of a file has it: the key of the channel, and its messages."""

    key: int
    topic: Topic
    messages: int


def distinct(profiles: Iterable[Qos]) -> list[Qos]:
    """Each profile once, in the order of their first occurrence."""
    found: dict[str, Qos] = {}
    for profile in profiles:
        found.setdefault(repr(sorted(profile.items())), profile)
    return list(found.values())


def merged(topics: Iterable[Topic]) -> list[Topic]:
    """One of each name, with the profiles of all: those of several channels may differ."""
    found: dict[str, list[Topic]] = {}
    for topic in topics:
        found.setdefault(topic.name, []).append(topic)
    return [_one_of(same) for same in found.values()]


def _one_of(same: Sequence[Topic]) -> Topic:
    if len(same) == 1:
        return same[0]
    return replace(same[0], qos=(*distinct(qos for topic in same for qos in topic.qos),))


class Message(NamedTuple):
    """A serialized message; times are nanoseconds since the epoch.

    `sequence` counts the messages of its publisher; 0 if unknown.
    """

    topic: str
    log_ns: int
    publish_ns: int
    sequence: int
    data: bytes


@dataclass(slots=True)
class Extent:
    """How many messages there are of each topic, and the times of the first and the last."""

    counts: dict[str, int] = field(default_factory=dict)
    start_ns: int = 0
    end_ns: int = 0

    @property
    def total(self) -> int:
        return sum(self.counts.values())

    @property
    def duration_ns(self) -> int:
        return self.end_ns - self.start_ns

    def add(self, topic: str, log_ns: int) -> None:
        if not self.counts:
            self.start_ns = self.end_ns = log_ns
        elif log_ns > self.end_ns:
            self.end_ns = log_ns
        elif log_ns < self.start_ns:
            self.start_ns = log_ns
        self.counts[topic] = self.counts.get(topic, 0) + 1

    def merge(self, other: Extent) -> None:
        if not other.counts:
            return
        if self.counts:
            self.start_ns = min(self.start_ns, other.start_ns)
            self.end_ns = max(self.end_ns, other.end_ns)
        else:
            self.start_ns, self.end_ns = other.start_ns, other.end_ns
        for topic, count in other.counts.items():
            self.counts[topic] = self.counts.get(topic, 0) + count


def summed(extents: Iterable[Extent]) -> Extent:
    whole = Extent()
    for extent in extents:
        whole.merge(extent)
    return whole


class Span(NamedTuple):
    """Times of messages from `start_ns` on and before `end_ns`; None is open."""

    start_ns: int | None = None
    end_ns: int | None = None


def never() -> bool:
    return False


class BagError(LauncherError):
    """A bag cannot be read or written; exit code 1."""


def one_line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
