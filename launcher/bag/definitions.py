"""Types as early and other recorders write them, in the form of today's rosbag2."""

from __future__ import annotations

import re
from dataclasses import replace

from launcher.bag.model import CDR, Definition, Topic

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


def normalized(topic: Topic) -> Topic:
    """With the type's name in three parts, and events of services with their own definition.

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
