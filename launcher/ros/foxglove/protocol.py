"""The WebSocket protocol of Foxglove: texts are JSON objects with an `op`, data is binary."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any

from launcher.base import strict_json

# The second one is the older name of the same protocol.
SUBPROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
CAPABILITIES = ("connectionGraph", "parameters", "parametersSubscribe")
WRITING_CAPABILITIES = ("clientPublish", "services")
ENCODINGS = ("cdr", "json")
SCHEMA_ENCODING = "ros2msg"

INFO, WARNING, ERROR = 0, 1, 2  # levels of a status

_MESSAGE_DATA, _SERVICE_RESPONSE = 1, 3  # from the server
_CLIENT_DATA, _SERVICE_REQUEST = 1, 2  # from a client
_U32 = 2**32


class ProtocolError(Exception):
    """What a client sent does not follow the protocol; the text is for that client."""


@dataclass(frozen=True, slots=True)
class Channel:
    """A topic, as clients know it."""

    id: int
    topic: str
    type: str
    schema: str

    def to_json(self) -> dict[str, Any]:
        return {
            "id": self.id,
            "topic": self.topic,
            "encoding": "cdr",
            "schemaName": self.type,
            "schema": self.schema,
            "schemaEncoding": SCHEMA_ENCODING,
        }


@dataclass(frozen=True, slots=True)
class AdvertisedService:
    """A service, as clients know it."""

    id: int
    name: str
    type: str
    request_schema: str
    response_schema: str

    def to_json(self) -> dict[str, Any]:
        def half(name: str, schema: str) -> dict[str, Any]:
            return {
                "encoding": "cdr",
                "schemaName": f"{self.type}_{name}",
                "schemaEncoding": SCHEMA_ENCODING,
                "schema": schema,
            }

        return {
            "id": self.id,
            "name": self.name,
            "type": self.type,
            "request": half("Request", self.request_schema),
            "response": half("Response", self.response_schema),
            # where clients looked for the schemas before
            "requestSchema": self.request_schema,
            "responseSchema": self.response_schema,
        }


@dataclass(frozen=True, slots=True)
class ClientData:
    """A message that a client publishes, on a channel that it has advertised."""

    channel: int
    payload: bytes


@dataclass(frozen=True, slots=True)
class ServiceCall:
    """A client calls a service."""

    service: int
    call: int
    encoding: str
    payload: bytes


def text(op: str, **fields: object) -> str:
    """A message of the server; None is left out."""
    given = {name: value for name, value in fields.items() if value is not None}
    return strict_json.dumps({"op": op, **given}, ensure_ascii=False)


def status(level: int, message: str) -> str:
    return text("status", level=level, message=message)


def message_data(subscription: int, time_ns: int, payload: bytes) -> bytes:
    return struct.pack("<BIQ", _MESSAGE_DATA, subscription, time_ns) + payload


def service_response(call: ServiceCall, payload: bytes) -> bytes:
    encoding = call.encoding.encode()
    head = struct.pack("<BIII", _SERVICE_RESPONSE, call.service, call.call, len(encoding))
    return head + encoding + payload


def parse_text(message: str) -> dict[str, Any]:
    """The object that a client has sent; its `op` is a string. ProtocolError."""
    try:
        found = strict_json.loads(message)
    except ValueError as error:
        raise ProtocolError(f"invalid message: not JSON: {error}") from None
    if not isinstance(found, dict) or not isinstance(found.get("op"), str):
        raise ProtocolError("invalid message: no object with an 'op'")
    return found


def parse_data(message: bytes) -> ClientData | ServiceCall:
    """What a client has sent in binary; ProtocolError."""
    kind = message[0] if message else None
    try:
        if kind == _CLIENT_DATA:
            return ClientData(struct.unpack_from("<I", message, 1)[0], message[5:])
        if kind == _SERVICE_REQUEST:
            service, call, length = struct.unpack_from("<III", message, 1)
            end = 13 + length
            if end <= len(message):
                return ServiceCall(service, call, message[13:end].decode(), message[end:])
    except (struct.error, UnicodeDecodeError):
        pass
    else:
        if kind != _SERVICE_REQUEST:
            raise ProtocolError(f"invalid message: no binary message has the opcode {kind}")
    raise ProtocolError("invalid message: a binary message is too short, or not UTF-8")


def numbers(message: dict[str, Any], field: str) -> list[int]:
    """A list of ids; ProtocolError."""
    return [_number(item, field) for item in _list(message, field)]


def strings(message: dict[str, Any], field: str) -> list[str]:
    """A list of names; ProtocolError."""
    found = _list(message, field)
    if not all(isinstance(item, str) for item in found):
        raise ProtocolError(f"invalid message: '{field}' must be a list of strings")
    return found


def objects(message: dict[str, Any], field: str, **kinds: type) -> list[dict[str, Any]]:
    """A list of objects with these fields of these types; ProtocolError."""
    found = _list(message, field)
    for item in found:
        if not isinstance(item, dict):
            raise ProtocolError(f"invalid message: '{field}' must be a list of objects")
        for name, kind in kinds.items():
            if kind is int:
                _number(item.get(name), f"{field}.{name}")
            elif not isinstance(item.get(name), kind):
                raise ProtocolError(f"invalid message: '{field}.{name}' is missing or not a string")
    return found


def identifier(message: dict[str, Any]) -> str | None:
    """The optional id of a request; ProtocolError."""
    found = message.get("id")
    if found is not None and not isinstance(found, str):
        raise ProtocolError("invalid message: 'id' must be a string")
    return found


def _list(message: dict[str, Any], field: str) -> list[Any]:
    found = message.get(field)
    if not isinstance(found, list):
        raise ProtocolError(f"invalid message: '{field}' must be a list")
    return found


def _number(value: object, field: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < _U32:
        raise ProtocolError(f"invalid message: '{field}' must be a number below 2^32")
    return value
