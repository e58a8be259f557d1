"""`bag info`: what a bag has, in the words of `ros2 bag info` and as JSON."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from launcher.bag import bag_actions, bag_services, quantity_texts
from launcher.bag.bag_model import Qos, Topic
from launcher.bag.reader import Bag
from launcher.bag.topic_course import ASCII_BLOCKS, BLOCKS, NS, TopicTimes, bar, measured

_INDENT = " " * 19
_SERVICE_INDENT = " " * 21
_JSON_PARTS = 60
_LEAST_WIDTH = 10

SORTS: Mapping[str, Callable[[Topic, int], Any]] = {
    "name": lambda topic, count: topic.name,
    "type": lambda topic, count: (topic.type, topic.name),
    "count": lambda topic, count: (-count, topic.name),
}


@dataclass(slots=True)
class Info:
    """A bag with what was asked for: `times` of its topics, and with `verbose` sizes and calls."""

    bag: Bag
    topics: list[Topic]
    times: Mapping[str, TopicTimes] | None = None
    sizes: dict[str, int] | None = None
    calls: dict[str, bag_services.CallCounter] = field(default_factory=dict)

    @property
    def plain_topics(self) -> list[Topic]:
        return [topic for topic in self._others if not bag_services.is_event(topic)]

    @property
    def services(self) -> list[Topic]:
        """The topics with calls of services."""
        return [topic for topic in self._others if bag_services.is_event(topic)]

    @property
    def _others(self) -> list[Topic]:
        of_actions = {topic.name for topics in self.actions.values() for topic in topics}
        return [topic for topic in self.topics if topic.name not in of_actions]

    @property
    def actions(self) -> dict[str, list[Topic]]:
        """The topics of each action."""
        found: dict[str, list[Topic]] = {}
        for topic in self.topics:
            if (action := bag_actions.action_of(topic.name, topic.type)) is not None:
                found.setdefault(action, []).append(topic)
        return found

    def count(self, topic: Topic) -> int:
        return self.bag.extent.counts.get(topic.name, 0)


def read(
    path: str,
    *,
    sort: str = "name",
    rates: bool = True,
    verbose: bool = False,
    width: int | None = None,
) -> Info:
    """`width` is that of the terminal; None is for JSON. BagError."""
    bag = Bag(path)
    counts = bag.extent.counts
    topics = sorted(bag.topics, key=lambda one: SORTS[sort](one, counts.get(one.name, 0)))
    info = Info(bag, topics)
    if rates:
        parts = _JSON_PARTS if width is None else _rate_widths(info, width)[1]
        ends = bag.extent.start_ns, bag.extent.end_ns
        info.times = measured(bag.times(), lambda: TopicTimes(*ends, parts))
    if verbose:
        _read_messages(info)
    return info


def _read_messages(info: Info) -> None:
    sizes = info.sizes = {topic.name: 0 for topic in info.topics}
    with_calls = (topic.name for topic in info.topics if bag_services.is_call(topic))
    info.calls = {name: bag_services.CallCounter() for name in with_calls}
    for message in info.bag.messages():
        sizes[message.topic] = sizes.get(message.topic, 0) + len(message.data)
        if (calls := info.calls.get(message.topic)) is not None:
            calls.add(message.data)


# ---- text


def lines(info: Info, width: int, *, ascii_only: bool = False) -> Iterator[str]:
    """`width` is that of the terminal."""
    bag = info.bag
    yield ""
    yield from _labelled("Files:", [os.path.basename(path) for path in bag.files], _INDENT)
    yield f"Bag size:          {quantity_texts.size(bag.size_bytes)}"
    yield f"Storage id:        {bag.storage}"
    yield f"ROS Distro:        {(bag.metadata and bag.metadata.ros_distro) or 'unknown'}"
    yield f"Duration:          {quantity_texts.duration(bag.extent.duration_ns)}"
    yield f"Start:             {quantity_texts.date(bag.extent.start_ns)}"
    yield f"End:               {quantity_texts.date(bag.extent.end_ns)}"
    yield f"Messages:          {sum(map(info.count, info.plain_topics))}"
    yield from _labelled("Topic information:", _topic_lines(info), _INDENT)
    if info.services:
        yield f"Service:           {len(info.services)}"
        yield from _labelled("Service information:", _service_lines(info), _SERVICE_INDENT)
    if actions := info.actions:
        yield f"Actions:           {len(actions)}"
        yield "Action information: "
        for action, topics in actions.items():
            yield from _action_lines(info, action, topics)
    if info.times is not None:
        yield from _rate_lines(info, width, ASCII_BLOCKS if ascii_only else BLOCKS)


def _labelled(label: str, texts: Sequence[str], indent: str) -> Iterator[str]:
    first, *others = texts or [""]
    yield f"{label.ljust(len(indent))}{first}"
    for text in others:
        yield f"{indent}{text}"


def _topic_lines(info: Info) -> list[str]:
    found: list[str] = []
    for topic in info.plain_topics:
        parts = [f"Topic: {topic.name}", f"Type: {topic.type}", f"Count: {info.count(topic)}"]
        parts += _tail(info, topic)
        found.append(" | ".join(parts))
        if info.sizes is not None:
            found += [f"  QoS: {qos_words(profile)}" for profile in topic.qos]
    return found


def _tail(info: Info, topic: Topic) -> Iterator[str]:
    if info.sizes is not None:
        yield f"Size Contribution: {quantity_texts.size(info.sizes[topic.name])}"
    yield f"Serialization Format: {topic.serialization}"


def _service_lines(info: Info) -> list[str]:
    found: list[str] = []
    for topic in info.services:
        parts = [
            f"Service: {bag_services.service_of(topic)}",
            f"Type: {bag_services.type_of(topic)}",
        ]
        parts += [_calls(info, topic), *_tail(info, topic)]
        found.append(" | ".join(parts))
    return found


def _calls(info: Info, topic: Topic | None) -> str:
    """How many there are, or events of them; a bag may lack the topic."""
    if info.sizes is None:
        return f"Event Count: {info.count(topic) if topic else 0}"
    calls = info.calls.get(topic.name if topic else "", bag_services.CallCounter())
    return f"Request Count: {calls.requests} | Response Count: {calls.responses}"


def _action_lines(info: Info, action: str, topics: Sequence[Topic]) -> Iterator[str]:
    """Also of the topics that are not in the bag, as rosbag2 has them."""
    found = {bag_actions.part_of(topic): topic for topic in topics}
    parts = [
        f"  Action: {action}",
        f"Type: {_action_type(topics) or 'unknown'}",
        f"Topics: {len(bag_actions.TOPICS)}",
        f"Service: {len(bag_actions.SERVICES)}",
        f"Serialization Format: {topics[0].serialization}",
    ]
    if info.sizes is not None:
        size = sum(info.sizes[topic.name] for topic in topics)
        parts.insert(-1, f"Size Contribution: {quantity_texts.size(size)}")
    yield " | ".join(parts)
    for name in bag_actions.TOPICS:
        yield f"    Topic: {name} | Count: {info.count(found[name]) if name in found else 0}"
    for name in bag_actions.SERVICES:
        yield f"    Service: {name} | {_calls(info, found.get(name))}"


def _action_type(topics: Iterable[Topic]) -> str:
    """Status and cancellations are of one type for all actions."""
    return next(filter(None, map(bag_actions.type_of, topics)), "")


def qos_words(profile: Qos) -> str:
    """`reliable, volatile, keep_last 10`; times only if they are finite."""
    history = str(profile.get("history", "unknown"))
    depth = f" {profile.get('depth')}" if history == "keep_last" else ""
    found = [
        str(profile.get("reliability", "unknown")),
        str(profile.get("durability", "unknown")),
        f"history {history}{depth}" if history == "unknown" else f"{history}{depth}",
    ]
    for name in ("deadline", "lifespan", "liveliness_lease_duration"):
        time = profile.get(name)
        sec, nsec = (time.get("sec", 0), time.get("nsec", 0)) if isinstance(time, dict) else (0, 0)
        if 0 < sec + nsec / NS < 9e9:
            found.append(f"{name} {sec + nsec / NS:g} s")
    return ", ".join(found)


def _rate_lines(info: Info, width: int, blocks: str) -> Iterator[str]:
    topics = [topic for topic in info.topics if info.count(topic)]
    if not topics or info.times is None:
        return
    name_width, parts = _rate_widths(info, width)
    scale_s = info.bag.extent.duration_ns / NS / parts
    yield f"Rates:             Hz over time, {scale_s:.3g} s in each column"
    header = _numbers("min", "mean", "max", "gap (s)")
    yield f"{'':{name_width}}  {'':{parts}}  {header}"
    for topic in topics:
        times = info.times.get(topic.name) or TopicTimes(parts=parts)
        found, gap = times.course(), times.longest_gap
        numbers = _numbers(
            hz(found.least_hz),
            hz(times.mean_hz),
            hz(found.most_hz),
            "-" if gap is None else f"{gap.length_ns / NS:.3g}",
        )
        yield f"{_short(topic.name, name_width)}  {bar(found.parts_hz, blocks)}  {numbers}"


def _rate_widths(info: Info, width: int) -> tuple[int, int]:
    """Of the names of topics, and of their bars."""
    longest = max((len(topic.name) for topic in info.topics if info.count(topic)), default=0)
    name_width = min(longest, max(width // 3, _LEAST_WIDTH))
    number_width = len(_numbers("", "", "", ""))
    return name_width, max(width - name_width - number_width - 4, _LEAST_WIDTH)


def _numbers(least: str, mean: str, most: str, gap: str) -> str:
    return f"{least:>7} {mean:>7} {most:>7} {gap:>7}"


def hz(rate: float | None) -> str:
    if rate is None:
        return "-"
    return f"{rate:.0f}" if rate >= 1000 else f"{rate:.3g}"


def _short(name: str, width: int) -> str:
    """The end of a long name: topics differ there."""
    return name.ljust(width) if len(name) <= width else f"~{name[len(name) - width + 1 :]}"


# ---- JSON


def document(info: Info) -> dict[str, Any]:
    bag, extent = info.bag, info.bag.extent
    return {
        "path": bag.path,
        "files": [os.path.basename(path) for path in bag.files],
        "size_bytes": bag.size_bytes,
        "storage": bag.storage,
        "ros_distro": bag.metadata.ros_distro if bag.metadata is not None else "",
        "start_ns": extent.start_ns,
        "end_ns": extent.end_ns,
        "duration_ns": extent.duration_ns,
        "messages": extent.total,
        "notes": bag.notes,
        "custom_data": dict(bag.metadata.custom_data) if bag.metadata is not None else {},
        "topics": [_topic(info, topic) for topic in info.plain_topics],
        "services": [_service(info, topic) for topic in info.services],
        "actions": [
            {
                "name": action,
                "type": _action_type(topics),
                "topics": [_topic(info, topic) for topic in topics],
            }
            for action, topics in info.actions.items()
        ],
    }


def _topic(info: Info, topic: Topic) -> dict[str, Any]:
    found: dict[str, Any] = {
        "name": topic.name,
        "type": topic.type,
        "messages": info.count(topic),
        "serialization_format": topic.serialization,
        "type_hash": topic.type_hash,
        "qos": [dict(profile) for profile in topic.qos],
    }
    if info.sizes is not None:
        found["size_bytes"] = info.sizes[topic.name]
    if info.times is not None:
        found["rate"] = _rate(info, topic)
    if (calls := info.calls.get(topic.name)) is not None:
        found |= {"requests": calls.requests, "responses": calls.responses}
    return found


def _rate(info: Info, topic: Topic) -> dict[str, Any]:
    times = (info.times or {}).get(topic.name) or TopicTimes(parts=_JSON_PARTS)
    found, gap = times.course(), times.longest_gap
    return {
        "mean_hz": times.mean_hz,
        "min_hz": found.least_hz,
        "max_hz": found.most_hz,
        "longest_gap_s": None if gap is None else gap.length_ns / NS,
        "longest_gap_start_ns": None if gap is None else gap.start_ns,
        "parts_hz": list(found.parts_hz),
    }


def _service(info: Info, topic: Topic) -> dict[str, Any]:
    found = {**_topic(info, topic), "name": bag_services.service_of(topic)}
    found["type"] = bag_services.type_of(topic)
    found["topic"] = topic.name
    return found
