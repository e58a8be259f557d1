"""Parses what a participant announces: its addresses, endpoints and nodes."""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Iterator
from dataclasses import dataclass

from launcher.ros.discovery import rtps
from launcher.ros.snapshot.ros_graph import (
    INFINITE_NS,
    UNKNOWN_HISTORY,
    Direction,
    EndpointInfo,
    shown_history,
)

_TOPIC, _TYPE, _GUID, _USER_DATA = 0x05, 0x07, 0x5A, 0x2C
_RELIABILITY, _DURABILITY, _LIVELINESS, _DEADLINE, _LIFESPAN = 0x1A, 0x1D, 0x1B, 0x23, 0x2B
_HISTORY = 0x40  # of Cyclone DDS, unless it is KEEP_LAST (1); not of Fast DDS 2.14 and 3.2
_METATRAFFIC, _DEFAULT, _ENDPOINT_SET = 0x32, 0x31, 0x58

_RELIABILITIES = {1: "BEST_EFFORT", 2: "RELIABLE"}
_DURABILITIES = {0: "VOLATILE", 1: "TRANSIENT_LOCAL"}
_HISTORIES = {0: "KEEP_LAST", 1: "KEEP_ALL"}
_LIVELINESSES = {0: "AUTOMATIC", 2: "MANUAL_BY_TOPIC"}
_OTHER = "UNKNOWN"  # ROS has no name for it


@contextlib.contextmanager
def _errors_as_value_errors() -> Iterator[None]:
    try:
        yield
    except (struct.error, IndexError) as error:
        raise ValueError("cut short") from error


@_errors_as_value_errors()
def endpoint_in(payload: bytes, direction: Direction) -> EndpointInfo:
    """The endpoint in a sample of SEDP, without its node; ValueError if there is none."""
    order, listed = rtps.parameters(payload)
    found = dict(listed)
    if not {_TOPIC, _TYPE, _GUID} <= found.keys():
        raise ValueError("no endpoint")
    liveliness = found.get(_LIVELINESS)
    # DDS's default for what is left out
    reliable = 2 if direction is Direction.PUBLISHER else 1
    return EndpointInfo(
        topic=rtps.text_in(found[_TOPIC], order),
        type=rtps.text_in(found[_TYPE], order),
        node="",
        direction=direction.value,
        reliability=_RELIABILITIES.get(_kind(found.get(_RELIABILITY), order, reliable), _OTHER),
        durability=_DURABILITIES.get(_kind(found.get(_DURABILITY), order, 0), _OTHER),
        liveliness=_LIVELINESSES.get(_kind(liveliness, order, 0), _OTHER),
        deadline_ns=_duration(found.get(_DEADLINE), order),
        lease_ns=_duration(liveliness and liveliness[4:], order),
        lifespan_ns=_duration(found.get(_LIFESPAN), order),
        type_hash=_type_hash(found.get(_USER_DATA, b"")),
        history=_history(found.get(_HISTORY), order),
        gid=found[_GUID].hex("."),
    )


def _kind(value: bytes | None, order: str, default: int) -> int:
    return default if value is None else int(struct.unpack_from(f"{order}I", value)[0])


def _duration(value: bytes | None, order: str) -> int:
    return rtps.nanoseconds_in(value, order) if value else INFINITE_NS


def _history(value: bytes | None, order: str) -> str:
    if value is None:
        return UNKNOWN_HISTORY
    kind, depth = struct.unpack_from(f"{order}Ii", value)
    return shown_history(_HISTORIES.get(kind, UNKNOWN_HISTORY), depth)


def _type_hash(user_data: bytes) -> str:
    for entry in user_data[4:].split(b";"):
        name, _, value = entry.partition(b"=")
        if name == b"typehash":
            return value.decode(errors="replace")
    return "INVALID"


def gone_guid(data: rtps.Data) -> bytes:
    """The endpoint that a sample disposes of; empty if it names none."""
    if data.key or not data.payload:
        return data.key
    return dict(rtps.parameters(data.payload)[1]).get(_GUID, b"")


@_errors_as_value_errors()
def contact_in(payload: bytes) -> tuple[int, int, int | None]:
    """A participant's UDP ports for discovery and for data, and its built-in endpoints.

    ValueError if it cannot be reached by UDP.
    """
    order, listed = rtps.parameters(payload)
    endpoint_set = dict(listed).get(_ENDPOINT_SET)
    metatraffic, data = (_udp_port(listed, n, order) for n in (_METATRAFFIC, _DEFAULT))
    builtin = None if endpoint_set is None else _kind(endpoint_set, order, 0)
    if metatraffic is None or data is None:
        raise ValueError("no UDP port")
    return metatraffic, data, builtin


def _udp_port(listed: list[tuple[int, bytes]], wanted: int, order: str) -> int | None:
    for number, value in listed:
        if number == wanted:
            kind, port = struct.unpack_from(f"{order}iI", value)
            if kind == rtps.UDP_V4:
                return int(port)
    return None


# the topic on which each participant of ROS publishes its nodes
NODES_TOPIC = "ros_discovery_info"
NODES_TYPE = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_"
# without it the others log an error
NODES_TYPE_HASH = "RIHS01_91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e"

_GID_BYTES = 16
_MAX = 65536  # entries; more is not a message of this type


@dataclass(frozen=True, slots=True, kw_only=True)
class NodeEndpoints:
    """A node by its full name, and the GIDs of its endpoints."""

    name: str
    gids: frozenset[bytes]


@_errors_as_value_errors()
def nodes_in(payload: bytes) -> tuple[NodeEndpoints, ...]:
    """The nodes in a sample of NODES_TOPIC; ValueError if it is malformed."""
    sample = _Cdr(payload)
    return tuple(sample.node() for _ in range(sample.count()))


class _Cdr:
    def __init__(self, payload: bytes) -> None:
        self._order = "<" if payload[1] & 1 else ">"
        self._body = payload[4:]
        self._at = _GID_BYTES  # the participant's own GID

    def node(self) -> NodeEndpoints:
        namespace, name = self._text(), self._text()
        gids = [self._gid() for _ in range(2) for _ in range(self.count())]
        return NodeEndpoints(name=f"{namespace.rstrip('/')}/{name}", gids=frozenset(gids))

    def count(self) -> int:
        self._at += -self._at % 4
        (count,) = struct.unpack_from(f"{self._order}I", self._body, self._at)
        self._at += 4
        if count > _MAX:
            raise ValueError(f"{count} entries")
        return int(count)

    def _text(self) -> str:
        length = self.count()
        word = self._body[self._at : self._at + length]
        self._at += length
        return word.rstrip(b"\0").decode(errors="replace")

    def _gid(self) -> bytes:
        gid = self._body[self._at : self._at + _GID_BYTES]
        if len(gid) < _GID_BYTES:
            raise ValueError("cut short")
        self._at += _GID_BYTES
        return gid
