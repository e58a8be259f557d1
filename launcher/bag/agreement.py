"""Topics of one name that have several types, definitions or encodings in a bag."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

from launcher.bag.bag_model import CDR, ROS2_MSG, ChannelTopic, Definition, Topic
from launcher.bag.metadata import FILE
from launcher.base.text import count

_COMMENT = re.compile(r"#.*")
_SEPARATOR = "=" * 80
_SECTION = re.compile(rf"^{_SEPARATOR}\n", re.MULTILINE)
_EVENT = re.compile(r"(\w+)/srv/(\w+)_Event")
_TWO_PARTS = re.compile(r"(\w+)/(\w+)")
_PARTS = re.compile(r"^---[ \t]*\r?\n?", re.MULTILINE)  # between request and response
_NEEDED = {  # by each event, and not in the text of a .srv
    "service_msgs/ServiceEventInfo": "uint8 event_type\nbuiltin_interfaces/Time stamp\n"
    "char[16] client_gid\nint64 sequence_number\n",
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
}


class LeftOut(NamedTuple):
    """The keys of the parts of a file that are left out, their messages, and sentences on them."""

    keys: frozenset[int]
    counts: dict[str, int]
    notes: list[str]


class Agreement:
    """Keeps of each topic what is like the first part with messages, over all files of a bag.

    Messages of other types, definitions or encodings cannot be in the same topic of a new bag, nor
    be published on it.
    """

    def __init__(self) -> None:
        self._known: dict[str, Topic] = {}

    def take(self, parts: Iterable[ChannelTopic]) -> LeftOut:
        """What does not agree in the next file, or in one that was taken before."""
        parts = list(parts)
        for part in parts:
            if part.messages:
                self._known.setdefault(part.topic.name, part.topic)
        first = {part.topic.name: part.topic for part in reversed(parts)} | self._known
        keys: set[int] = set()
        numbers: dict[tuple[str, str], int] = {}
        for part in parts:
            name = part.topic.name
            if other := difference(first[name], part.topic):
                keys.add(part.key)
                numbers[name, other] = numbers.get((name, other), 0) + part.messages
        counts: dict[str, int] = {}
        for (name, _), number in numbers.items():
            if number:
                counts[name] = counts.get(name, 0) + number
        notes = [self._note(*which, number) for which, number in numbers.items() if number]
        return LeftOut(frozenset(keys), counts, notes)

    def difference(self, topic: Topic) -> str | None:
        """What `topic` has that is not as in the part that is kept; None if they agree."""
        return difference(self._known.get(topic.name, topic), topic)

    def _note(self, name: str, other: str, number: int) -> str:
        known = normalized(self._known[name])
        verb = "is" if number == 1 else "are"
        return (
            f"{name} is {known.type or 'of no type'} ({known.serialization or 'no encoding'}); "
            f"{count(number, 'message')} of {other} {verb} left out"
        )


def contradiction(listed: Topic, topic: Topic) -> str | None:
    """How the type of a topic in the metadata of a bag differs from that in its file."""
    said = normalized(replace(listed, serialization=topic.serialization)).type
    found = normalized(topic).type
    if not said or not found or said == found:
        return None
    return f"{FILE} says that {topic.name} is {said}; the files have {found}"


def difference(kept: Topic, other: Topic) -> str | None:
    """What `other` is of, if messages of both cannot be in one topic: `Int32 (cdr)`."""
    kept, other = normalized(kept), normalized(other)
    if (kept.type, kept.serialization) != (other.type, other.serialization):
        return f"{other.type or 'no type'} ({other.serialization or 'no encoding'})"
    if kept.type_hash and other.type_hash:
        is_same = kept.type_hash == other.type_hash
    else:
        is_same = _is_same(kept.definition, other.definition)
    return None if is_same else f"another definition of {other.type or 'no type'}"


def _is_same(a: Definition | None, b: Definition | None) -> bool:
    """Whether two definitions of a type are, or may be: one is unknown or in another language."""
    if a is None or b is None or a == b or a.encoding != b.encoding:
        return True
    return a.encoding == ROS2_MSG and _sections(a.text) == _sections(b.text)


def _sections(text: str) -> list[list[str]]:
    """The words of the type, and those of the types that it needs, in any order."""
    first, *others = re.split(r"^=+$", text.replace("/msg/", "/"), flags=re.MULTILINE)
    return [_COMMENT.sub("", first).split(), *sorted(_COMMENT.sub("", o).split() for o in others)]


def normalized(topic: Topic) -> Topic:
    """Its type as today's rosbag2 writes it, which early and other recorders write in other ways.

    With the name in three parts, and events of services with their own definition.
    The first distributions have `std_msgs/String`. rosbag2 gives events the text of the .srv.
    """
    if topic.serialization != CDR:
        return topic
    if two := _TWO_PARTS.fullmatch(topic.type):
        return replace(topic, type=f"{two[1]}/msg/{two[2]}")
    event = _EVENT.fullmatch(topic.type)
    if event is None or topic.definition is None:
        return topic
    text = _of_events(f"{event[1]}/{event[2]}", topic.definition.text)
    return topic if text is None else replace(topic, definition=Definition(text=text))


def _of_events(service: str, text: str) -> str | None:
    """The definition of a service's events; None if the text is not that of its .srv."""
    first, *others = _SECTION.split(text)
    if not first.strip() and others:
        head, _, first = others.pop(0).partition("\n")
        if not head.startswith("SRV:"):
            return None
    parts = _PARTS.split(first)
    if len(parts) != 2 or any(not one.startswith("MSG:") for one in others):
        return None
    event = (
        "service_msgs/ServiceEventInfo info\n"
        f"{service}_Request[<=1] request\n{service}_Response[<=1] response\n"
    )
    known = {one.partition("\n")[0].removeprefix("MSG:").strip() for one in others}
    added = {name: one for name, one in _NEEDED.items() if name not in known}
    own = {f"{service}_Request": parts[0], f"{service}_Response": parts[1]}
    sections = [f"MSG: {name}\n{one}" for name, one in {**added, **own}.items()]
    return f"\n{_SEPARATOR}\n".join([event, *sections, *others])
