"""What is typical of a topic in a bag, and whether it is alike in two."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass

from launcher.bag.bag_model import Topic
from launcher.bag.topic_course import NS, TopicTimes

MIN_MESSAGES = 5  # of fewer, the rate is not judged
GAP_SLACK_S = 0.1  # of the longest gap: what a busy machine makes of any topic


@dataclass(frozen=True, slots=True, kw_only=True)
class Traits:
    """A topic with the number of its messages, its mean rate and its longest gap.

    Latencies are the times from publishing to recording; None if there is no message.
    """

    name: str
    type: str
    type_hash: str = ""
    count: int = 0
    start_ns: int = 0
    rate_hz: float | None = None
    gap_s: float | None = None
    latency_s: float | None = None
    latency_p99_s: float | None = None

    def document(self) -> dict[str, object]:
        """For JSON, with the names of `bag info`."""
        found = asdict(self)
        return {"name": found.pop("name"), "messages": found.pop("count"), **found}


def traits_of(topic: Topic, times: TopicTimes, latencies_ns: Sequence[int] = ()) -> Traits:
    gap = times.longest_gap
    ordered = sorted(latencies_ns)
    return Traits(
        name=topic.name,
        type=topic.type,
        type_hash=topic.type_hash,
        count=times.count,
        start_ns=times.first_ns,
        rate_hz=times.mean_hz,
        gap_s=None if gap is None else gap.length_ns / NS,
        latency_s=ordered[len(ordered) // 2] / NS if ordered else None,
        latency_p99_s=ordered[(len(ordered) * 99) // 100] / NS if ordered else None,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Limit:
    """How far a number may be from another one: absolutely, and as a part of it."""

    absolute: float = 0.0
    relative: float = 0.0

    def allows(self, a: float, b: float) -> bool:
        return abs(a - b) <= max(self.absolute, self.relative * abs(a))


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerances:
    """None: not judged. A gap may only be too long."""

    count: Limit | None = None
    rate: Limit | None = None
    gap: Limit | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """`kind` is missing, extra, type, hash, encoding, definition, count, rate, gap, field or data,
    or `left out`: messages that are not compared, since they are not of the type of their topic.
    """

    kind: str
    a: object
    b: object
    path: str = ""
    index: int | None = None
    note: str = ""


def differences(a: Traits | None, b: Traits | None, allowed: Tolerances) -> Iterator[Difference]:
    """Between a topic of two bags, of which one may lack it."""
    if a is None or b is None:
        if a is not None:
            yield Difference(kind="missing", a=a.type, b=None)
        elif b is not None:
            yield Difference(kind="extra", a=None, b=b.type)
        return
    if a.type != b.type:
        yield Difference(kind="type", a=a.type, b=b.type)
    elif a.type_hash and b.type_hash and a.type_hash != b.type_hash:
        yield Difference(kind="hash", a=a.type_hash, b=b.type_hash)
    if allowed.count is not None and not allowed.count.allows(a.count, b.count):
        yield Difference(kind="count", a=a.count, b=b.count)
    yield from _timing(a, b, allowed)


def _timing(a: Traits, b: Traits, allowed: Tolerances) -> Iterator[Difference]:
    if a.count < MIN_MESSAGES or a.rate_hz is None:
        return
    if allowed.rate is not None and not allowed.rate.allows(a.rate_hz, b.rate_hz or 0.0):
        yield Difference(kind="rate", a=a.rate_hz, b=b.rate_hz or 0.0)
    if allowed.gap is None or a.gap_s is None or b.gap_s is None:
        return
    if b.gap_s > a.gap_s + GAP_SLACK_S and not allowed.gap.allows(a.gap_s, b.gap_s):
        yield Difference(kind="gap", a=a.gap_s, b=b.gap_s)


def text_of(one: Difference, a: str = "in A", b: str = "in B") -> str:
    """What differs, with words for both places."""
    match one.kind:
        case "missing":
            return f"only {a} ({one.a})"
        case "extra":
            return f"only {b} ({one.b})"
        case "type":
            return f"{one.a} {a}, {one.b} {b}"
        case "hash":
            return f"the type is not defined in the same way ({one.a} {a}, {one.b} {b})"
        case "encoding":
            return f"messages are in '{one.a}' {a}, in '{one.b}' {b}"
        case "definition":
            return f"{one.a} is not defined in the same way {a} and {b}"
        case "left out":
            return f"{one.a} messages {a} and {one.b} {b} are of another type, and not compared"
        case "count":
            return f"{one.a} messages {a}, {one.b} {b}"
        case "rate":
            return f"{one.a:.3g} Hz {a}, {one.b:.3g} Hz {b}"
        case "gap":
            return f"the longest gap is {one.a:.3g} s {a}, {one.b:.3g} s {b}"
        case "field":
            return f"message {one.index}: {one.path} is {_shown(one.a)} {a}, {_shown(one.b)} {b}"
        case _:
            return f"message {one.index} has other bytes, and {one.note}"


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."
