"""Parses and writes the messages of DDS discovery that the reader needs.

Only what the standard (RTPS 2.3) defines, so that participants of any vendor answer: SPDP announces
participants, SEDP their endpoints. Byte order is a flag of each submessage.
"""

from __future__ import annotations

import os
import struct

from launcher.base.model.record import Record

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

UNKNOWN_VENDOR = bytes(2)
UDP_V4 = 1  # the kind of a locator
PREFIX_BYTES = 12  # of a GUID: the participant; the last four bytes are the entity

PARTICIPANT = bytes.fromhex("000001c1")
SPDP_WRITER = bytes.fromhex("000100c2")
SPDP_READER = bytes.fromhex("000100c7")
PUBLICATIONS_WRITER = bytes.fromhex("000003c2")
PUBLICATIONS_READER = bytes.fromhex("000003c7")
SUBSCRIPTIONS_WRITER = bytes.fromhex("000004c2")
SUBSCRIPTIONS_READER = bytes.fromhex("000004c7")

_PAD, _ACKNACK, _HEARTBEAT, _GAP, _INFO_DST, _DATA, _DATA_FRAG = 1, 6, 7, 8, 14, 21, 22
_LITTLE, _INLINE_QOS, _PAYLOAD, _KEY = 1, 2, 4, 8
_PID_SENTINEL, _PID_STATUS = 0x0001, 0x0071
PID_KEY_HASH = 0x0070
_MUST_UNDERSTAND = 0x4000
_PL_CDR_LITTLE = bytes([0, 3, 0, 0])
WINDOW = 256  # sequence numbers that one ACKNACK can ask for


class Data(Record):
    """A sample; one that disposes of something may have a `key` instead of a payload."""

    writer: bytes
    number: int
    payload: bytes
    gone: bool
    key: bytes


class Heartbeat(Record):
    """A writer holds the samples `first` to `last`."""

    writer: bytes
    first: int
    last: int


class Gap(Record):
    """A writer no longer holds these samples."""

    writer: bytes
    numbers: frozenset[int]


class AckNack(Record):
    """A reader requests samples from one of our writers."""

    reader: bytes
    writer_entity: bytes


class Fragment(Record):
    """A part of a sample that is too large for one datagram."""

    writer: bytes


Part = Data | Heartbeat | Gap | AckNack | Fragment


def parts(datagram: bytes, own_prefix: bytes) -> Iterator[Part]:
    """The submessages that are for us; ValueError if the datagram is malformed."""
    if datagram[:4] != b"RTPS" or len(datagram) < 20:
        raise ValueError("not RTPS")
    try:
        yield from _parts(datagram, own_prefix)
    except (struct.error, IndexError) as error:
        raise ValueError("malformed submessage") from error


def _parts(datagram: bytes, own_prefix: bytes) -> Iterator[Part]:
    source, for_us, at = datagram[8:20], True, 20
    while at + 4 <= len(datagram):
        kind, flags = datagram[at], datagram[at + 1]
        order = "<" if flags & _LITTLE else ">"
        (length,) = struct.unpack_from(f"{order}H", datagram, at + 2)
        if length == 0 and kind not in (_PAD, 9):  # the last one may extend to the end
            length = len(datagram) - at - 4
        body = datagram[at + 4 : at + 4 + length]
        at += 4 + length
        if kind == _INFO_DST:
            for_us = body[:PREFIX_BYTES] in (own_prefix, bytes(PREFIX_BYTES))
        elif for_us and (reader := _READ.get(kind)):
            yield reader(source, flags, order, body)


def _data(source: bytes, flags: int, order: str, body: bytes) -> Data:
    (to_inline,) = struct.unpack_from(f"{order}H", body, 2)
    at, status, key = 4 + to_inline, 0, b""
    if flags & _INLINE_QOS:
        inline, at = _parameter_list(body, at, order)
        status = inline.get(_PID_STATUS, bytes(4))[3]
        key = inline.get(PID_KEY_HASH, b"")
    return Data(
        writer=source + body[8:12],
        number=_number(body, 12, order),
        payload=body[at:] if flags & _PAYLOAD else b"",
        gone=status != 0,
        key=key,
    )


def _heartbeat(source: bytes, flags: int, order: str, body: bytes) -> Heartbeat:
    first, last = _number(body, 8, order), _number(body, 16, order)
    return Heartbeat(writer=source + body[4:8], first=first, last=last)


def _gap(source: bytes, flags: int, order: str, body: bytes) -> Gap:
    start, base = _number(body, 8, order), _number(body, 16, order)
    if not 0 <= base - start <= 2**16:
        raise ValueError("malformed gap")
    listed = {base + bit for bit in _bits(body, 24, order)}
    return Gap(writer=source + body[4:8], numbers=frozenset({*range(start, base), *listed}))


def _request(source: bytes, flags: int, order: str, body: bytes) -> AckNack:
    return AckNack(reader=source + body[:4], writer_entity=body[4:8])


def _fragment(source: bytes, flags: int, order: str, body: bytes) -> Fragment:
    return Fragment(writer=source + body[8:12])


_READ: dict[int, Callable[[bytes, int, str, bytes], Part]] = {
    _DATA: _data,
    _HEARTBEAT: _heartbeat,
    _GAP: _gap,
    _ACKNACK: _request,
    _DATA_FRAG: _fragment,
}


def _number(body: bytes, at: int, order: str) -> int:
    high, low = struct.unpack_from(f"{order}iI", body, at)
    return int(high) << 32 | int(low)


def _bits(body: bytes, at: int, order: str) -> Iterator[int]:
    (count,) = struct.unpack_from(f"{order}I", body, at)
    if count > WINDOW:
        raise ValueError("too many sequence numbers")
    words = struct.unpack_from(f"{order}{(count + 31) // 32}I", body, at + 4)
    return (bit for bit in range(count) if words[bit // 32] >> (31 - bit % 32) & 1)


def _parameter_list(body: bytes, at: int, order: str) -> tuple[dict[int, bytes], int]:
    found: dict[int, bytes] = {}
    while True:
        number, length = struct.unpack_from(f"{order}HH", body, at)
        at += 4
        if number == _PID_SENTINEL:
            return found, at
        found.setdefault(number & ~_MUST_UNDERSTAND, body[at : at + length])
        at += length


def parameters(payload: bytes) -> tuple[str, list[tuple[int, bytes]]]:
    """Byte order and parameters of a parameter list; ValueError if it is malformed."""
    order = {b"\0\3": "<", b"\0\2": ">"}.get(payload[:2])
    if order is None:
        raise ValueError("not a parameter list")
    at, found = 4, list[tuple[int, bytes]]()
    while at + 4 <= len(payload):
        number, length = struct.unpack_from(f"{order}HH", payload, at)
        if number == _PID_SENTINEL:
            break
        found.append((number & ~_MUST_UNDERSTAND, payload[at + 4 : at + 4 + length]))
        at += 4 + length
    return order, found


def message(prefix: bytes, vendor: bytes, *submessages: bytes) -> bytes:
    return b"RTPS" + bytes([2, 3]) + vendor + prefix + b"".join(submessages)


def to(prefix: bytes) -> bytes:
    """The following submessages are for this participant."""
    return _submessage(_INFO_DST, 0, prefix)


def sample(reader: bytes, writer: bytes, number: int, listed: list[tuple[int, bytes]]) -> bytes:
    """A sample that is a parameter list."""
    body = struct.pack("<HH", 0, 16) + reader + writer + struct.pack("<iI", 0, number)
    return _submessage(_DATA, _PAYLOAD, body + _PL_CDR_LITTLE + _listed(listed))


def new_prefix() -> bytes:
    """For a participant of ours."""
    return UNKNOWN_VENDOR + os.urandom(PREFIX_BYTES - len(UNKNOWN_VENDOR))


def announcement(
    prefix: bytes, number: int, locators: list[bytes], *, endpoints: int, lease_s: int
) -> bytes:
    """The sample that announces a participant of ours; `endpoints` is the set of its built-in ones.

    Others forget it `lease_s` after the last one.
    """
    listed = [
        (0x15, bytes([2, 3])),
        (0x16, UNKNOWN_VENDOR),
        (0x50, prefix + PARTICIPANT),
        *((0x32, locator) for locator in locators),
        *((0x31, locator) for locator in locators),
        (0x02, struct.pack("<iI", lease_s, 0)),
        (0x58, struct.pack("<I", endpoints)),
    ]
    return sample(SPDP_READER, SPDP_WRITER, number, listed)


def end_of_participant(prefix: bytes, number: int) -> bytes:
    """The sample that disposes of a participant (RTPS 2.x, 8.5.3)."""
    return end_of(SPDP_READER, SPDP_WRITER, number, prefix + PARTICIPANT)


def repeated(reader: bytes, sample: Data) -> bytes:
    """The submessage with which a participant sent this sample."""
    entity = sample.writer[PREFIX_BYTES:]
    numbers = struct.pack("<iI", sample.number >> 32, sample.number & 0xFFFFFFFF)
    body = struct.pack("<HH", 0, 16) + reader + entity + numbers + sample.payload
    return _submessage(_DATA, _PAYLOAD, body)


def end_of(reader: bytes, writer: bytes, number: int, guid: bytes) -> bytes:
    """The sample that disposes of what has this GUID."""
    body = struct.pack("<HH", 0, 16) + reader + writer + struct.pack("<iI", 0, number)
    # disposed and unregistered
    qos = _listed([(PID_KEY_HASH, guid), (_PID_STATUS, bytes([0, 0, 0, 3]))])
    return _submessage(_DATA, _INLINE_QOS, body + qos)


def heartbeat(reader: bytes, writer: bytes, last: int, count: int) -> bytes:
    """Our writer holds the samples from 1 to `last`."""
    numbers = struct.pack("<iIiIi", 0, 1, 0, last, count)
    return _submessage(_HEARTBEAT, 0, reader + writer + numbers)


def ask(reader: bytes, writer: bytes, missing: list[int], count: int) -> bytes:
    """Our reader requests these samples (sorted, not empty), as many as one ACKNACK can name."""
    base = missing[0]
    bits = [number - base for number in missing if number - base < WINDOW]
    words = [0] * (bits[-1] // 32 + 1)
    for bit in bits:
        words[bit // 32] |= 1 << (31 - bit % 32)
    size = bits[-1] + 1
    body = reader + writer + struct.pack("<iII", base >> 32, base & 0xFFFFFFFF, size)
    body += struct.pack(f"<{len(words)}Ii", *words, count)
    return _submessage(_ACKNACK, 0, body)


def _listed(listed: list[tuple[int, bytes]]) -> bytes:
    return b"".join(parameter(n, v) for n, v in listed) + struct.pack("<HH", _PID_SENTINEL, 0)


def parameter(number: int, value: bytes) -> bytes:
    value += bytes(-len(value) % 4)
    return struct.pack("<HH", number, len(value)) + value


def _submessage(kind: int, flags: int, body: bytes) -> bytes:
    return struct.pack("<BBH", kind, flags | _LITTLE, len(body)) + body


def locator(host: str, port: int) -> bytes:
    """An address of UDP over IPv4."""
    address = bytes(12) + bytes(map(int, host.split(".")))
    return struct.pack("<iI", UDP_V4, port) + address


def text(value: str) -> bytes:
    """A string in CDR."""
    encoded = value.encode() + b"\0"
    return struct.pack("<I", len(encoded)) + encoded


def text_in(value: bytes, order: str) -> str:
    (length,) = struct.unpack_from(f"{order}I", value)
    return value[4 : 4 + length].rstrip(b"\0").decode(errors="replace")


def nanoseconds_in(value: bytes, order: str) -> int:
    """The duration in a parameter; infinite is the largest one of ROS."""
    seconds, fraction = struct.unpack_from(f"{order}iI", value)
    if seconds == 0x7FFFFFFF:
        return 2**63 - 1
    return int(seconds) * 10**9 + (int(fraction) * 10**9 + 2**31 >> 32)
