"""A client of Foxglove's WebSocket protocol, which decodes messages by the schemas that it gets."""

from __future__ import annotations

import contextlib
import json
import struct
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from mcap_ros2._dynamic import generate_dynamic, serialize_dynamic
from rclpy.serialization import serialize_message
from std_msgs.msg import String
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

from tests.support.waiting import wait_until

SUBPROTOCOL = "foxglove.sdk.v1"


@dataclass(slots=True)
class Received:
    """Messages of one subscription: (time in ns, bytes)."""

    channel: dict[str, Any]
    messages: list[tuple[int, bytes]] = field(default_factory=list)

    def decoded(self) -> list[Any]:
        kind = self.channel["schemaName"]
        decode = generate_dynamic(kind, self.channel["schema"])[kind]
        return [decode(payload) for _, payload in list(self.messages)]


class FoxgloveClient:
    """A thread reads all that comes. `services` and `channels` are those offered now, by name."""

    def __init__(self, url: str, subprotocol: str = SUBPROTOCOL) -> None:
        self._stack = contextlib.ExitStack()
        self.socket: ClientConnection = self._stack.enter_context(
            connect(url, subprotocols=[Subprotocol(subprotocol)], max_size=None, compression=None)
        )
        self.info: dict[str, Any] = {}
        self.channels: dict[str, dict[str, Any]] = {}
        self.services: dict[str, dict[str, Any]] = {}
        self.received: dict[int, Received] = {}
        self.statuses: list[dict[str, Any]] = []
        self.values: list[dict[str, Any]] = []  # of parameters
        self.connections: list[dict[str, Any]] = []
        self.answers: dict[int, tuple[str, bytes] | str] = {}  # of services; a text: a failure
        self.is_closed = False
        self._numbers = iter(range(1, 10**9))
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()
        self.wait(lambda: self.info, "server info")

    def close(self) -> None:
        self._stack.close()
        self._thread.join()

    def wait(self, fact: Callable[[], Any], what: str) -> Any:
        wait_until(fact, f"{what}; statuses: {self.statuses}")
        return fact()

    def send(self, op: str, **fields: Any) -> None:
        self.socket.send(json.dumps({"op": op, **fields}))

    def channel(self, topic: str) -> dict[str, Any]:
        found: dict[str, Any] = self.wait(lambda: self.channels.get(topic), f"channel of {topic}")
        return found

    def subscribe(self, topic: str) -> Received:
        received = Received(self.channel(topic))
        self._subscribe(received)
        return received

    def _subscribe(self, received: Received) -> None:
        number, channel = next(self._numbers), received.channel["id"]
        self.received[number] = received
        self.send("subscribe", subscriptions=[{"id": number, "channelId": channel}])

    def unsubscribe(self, received: Received) -> None:
        numbers = [number for number, one in self.received.items() if one is received]
        for number in numbers:
            del self.received[number]
        self.send("unsubscribe", subscriptionIds=numbers)

    def advertise(self, topic: str, kind: str, encoding: str = "cdr") -> int:
        number = next(self._numbers)
        channel = {"id": number, "topic": topic, "encoding": encoding, "schemaName": kind}
        self.send("advertise", channels=[channel])
        return number

    def publish(self, channel: int, payload: bytes) -> None:
        self.socket.send(struct.pack("<BI", 1, channel) + payload)

    def call(self, name: str, request: dict[str, Any]) -> Any:
        """The decoded answer of a service, or the text of a failure."""
        service = self.wait(lambda: self.services.get(name), f"service {name}")
        sent, reply = service["request"], service["response"]
        encode = serialize_dynamic(sent["schemaName"], sent["schema"])[sent["schemaName"]]
        answer = self.call_raw(service["id"], sent["encoding"], encode(request))
        if isinstance(answer, str):
            return answer
        decode = generate_dynamic(reply["schemaName"], reply["schema"])[reply["schemaName"]]
        return decode(answer[1])

    def call_raw(self, service: int, encoding: str, payload: bytes) -> tuple[str, bytes] | str:
        call = next(self._numbers)
        head = struct.pack("<BIII", 2, service, call, len(encoding)) + encoding.encode()
        self.socket.send(head + payload)
        answer: tuple[str, bytes] | str = self.wait(lambda: self.answers.get(call), "an answer")
        return answer

    def get_parameters(self, *names: str) -> dict[str, dict[str, Any]]:
        return self._ask("getParameters", parameterNames=list(names))

    def set_parameters(self, *items: dict[str, Any]) -> dict[str, dict[str, Any]]:
        return self._ask("setParameters", parameters=list(items))

    def _ask(self, op: str, **fields: Any) -> dict[str, dict[str, Any]]:
        request = f"request {next(self._numbers)}"
        self.send(op, id=request, **fields)
        found = self.wait(lambda: [v for v in self.values if v.get("id") == request], op)
        return {one["name"]: one for one in found[0]["parameters"]}

    def updates(self, name: str) -> list[Any]:
        """The values of a parameter that came unasked."""
        pushed = [one["parameters"] for one in self.values if "id" not in one]
        return [one.get("value") for values in pushed for one in values if one["name"] == name]

    def _read(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            for message in self.socket:
                if isinstance(message, str):
                    self._take_text(json.loads(message))
                else:
                    self._take_data(message)
        self.is_closed = True

    def _take_text(self, message: dict[str, Any]) -> None:
        match message["op"]:
            case "serverInfo":
                self.info = message
            case "status":
                self.statuses.append(message)
            case "advertise":
                for channel in message["channels"]:
                    self._take_channel(channel)
            case "unadvertise":
                _remove(self.channels, message["channelIds"])
            case "advertiseServices":
                self.services.update({one["name"]: one for one in message["services"]})
            case "unadvertiseServices":
                _remove(self.services, message["serviceIds"])
            case "parameterValues":
                self.values.append(message)
            case "connectionGraphUpdate":
                self.connections.append(message)
            case "serviceCallFailure":
                self.answers[message["callId"]] = message["message"]
            case unknown:
                raise AssertionError(f"unknown op {unknown}")

    def _take_channel(self, channel: dict[str, Any]) -> None:
        """Subscribe again to a topic that was gone."""
        self.channels[channel["topic"]] = channel
        for number, received in list(self.received.items()):
            if received.channel["topic"] == channel["topic"]:
                del self.received[number]
                received.channel = channel
                self._subscribe(received)

    def _take_data(self, message: bytes) -> None:
        if message[0] == 1:
            number, time_ns = struct.unpack_from("<IQ", message, 1)
            if number in self.received:  # it may have been unsubscribed meanwhile
                self.received[number].messages.append((time_ns, message[13:]))
        elif message[0] == 3:
            _, call, length = struct.unpack_from("<III", message, 1)
            encoding = message[13 : 13 + length].decode()
            self.answers[call] = (encoding, message[13 + length :])
        else:
            raise AssertionError(f"unknown opcode {message[0]}")


def _remove(offered: dict[str, dict[str, Any]], numbers: list[int]) -> None:
    for name in [name for name, one in offered.items() if one["id"] in numbers]:
        del offered[name]


@contextlib.contextmanager
def connected(url: str, subprotocol: str = SUBPROTOCOL) -> Iterator[FoxgloveClient]:
    client = FoxgloveClient(url, subprotocol)
    try:
        yield client
    finally:
        client.close()


def cdr(text: str) -> bytes:
    return bytes(serialize_message(String(data=text)))


def texts(client: FoxgloveClient) -> str:
    return "\n".join(status["message"] for status in client.statuses)
