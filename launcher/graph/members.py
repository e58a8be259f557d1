"""Members: what each participant of ROS writes about its nodes, on the topic ros_discovery_info."""

from __future__ import annotations

import struct
from dataclasses import dataclass

TOPIC = "ros_discovery_info"
TYPE = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_"
# Without it the others complain in their logs; it says which definition of the type we mean.
TYPE_HASH = "RIHS01_91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e"

_GID_BYTES = 16
_MOST = 65536  # more entries than this is not a message of this type


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """A node by its full name, and the GIDs of its endpoints."""

    name: str
    gids: frozenset[bytes]


def members_in(payload: bytes) -> tuple[Member, ...]:
    """The nodes in a sample; ValueError if it is none of this type."""
    try:
        return _Cdr(payload).members()
    except (struct.error, IndexError) as error:
        raise ValueError("cut short") from error


class _Cdr:
    """Reads one sample from its start to its end."""

    def __init__(self, payload: bytes) -> None:
        self._order = "<" if payload[1] & 1 else ">"
        self._body = payload[4:]
        self._at = _GID_BYTES  # the participant's own GID

    def members(self) -> tuple[Member, ...]:
        return tuple(self._member() for _ in range(self._count()))

    def _member(self) -> Member:
        namespace, name = self._text(), self._text()
        gids = [self._gid() for _ in range(2) for _ in range(self._count())]
        return Member(name=f"{namespace.rstrip('/')}/{name}", gids=frozenset(gids))

    def _count(self) -> int:
        self._at += -self._at % 4
        (count,) = struct.unpack_from(f"{self._order}I", self._body, self._at)
        self._at += 4
        if count > _MOST:
            raise ValueError(f"{count} entries")
        return int(count)

    def _text(self) -> str:
        length = self._count()
        word = self._body[self._at : self._at + length]
        self._at += length
        return word.rstrip(b"\0").decode(errors="replace")

    def _gid(self) -> bytes:
        gid = self._body[self._at : self._at + _GID_BYTES]
        if len(gid) < _GID_BYTES:
            raise ValueError("cut short")
        self._at += _GID_BYTES
        return gid
