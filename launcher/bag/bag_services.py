"""Calls of services in bags: topics with the events of service introspection."""

from __future__ import annotations

import struct

from launcher.bag.bag_model import Topic

EVENTS = "/_service_event"
# What a service event begins with: the kind of event, the stamp, the client, the number of its
# call; they follow four bytes with the encoding.
_CALL = "4xB3x8x16s4xq"
_LITTLE, _BIG = struct.Struct(f"<{_CALL}"), struct.Struct(f">{_CALL}")
_REQUESTS, _RESPONSES = (0, 1), (2, 3)  # sent or received, of service_msgs/ServiceEventInfo


def is_event(topic: Topic) -> bool:
    return "/srv/" in topic.type and is_call(topic)


def is_call(topic: Topic) -> bool:
    """Whether it has events of a service, or of one of the services of an action."""
    return topic.type.endswith("_Event") and topic.name.endswith(EVENTS)


def service_of(topic: Topic) -> str:
    return topic.name.removesuffix(EVENTS)


def type_of(topic: Topic) -> str:
    return topic.type.removesuffix("_Event")


class CallCounter:
    """Counts calls; events of client and server may be of the same call."""

    def __init__(self) -> None:
        self._requests: set[tuple[bytes, int]] = set()
        self._responses: set[tuple[bytes, int]] = set()

    @property
    def requests(self) -> int:
        return len(self._requests)

    @property
    def responses(self) -> int:
        return len(self._responses)

    def add(self, data: bytes) -> None:
        """An event; one that is too short counts as none."""
        if len(data) < _LITTLE.size:
            return
        kind, client, number = (_LITTLE if data[1] & 1 else _BIG).unpack_from(data)
        if kind in _REQUESTS:
            self._requests.add((client, number))
        elif kind in _RESPONSES:
            self._responses.add((client, number))
