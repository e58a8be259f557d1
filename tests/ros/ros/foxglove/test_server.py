"""`foxglove` as a program: clients that do not read, options, its end, and the types it tells."""

from __future__ import annotations

import contextlib
import json
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import foxglove
import pytest
from foxglove.websocket import Capability
from rclpy.serialization import serialize_message
from std_msgs.msg import UInt8MultiArray
from std_srvs.srv import Trigger
from websockets.sync.client import ClientConnection, connect

from launcher.base.errors import ExitCode
from launcher.ros.discovery.observer import Observer
from launcher.ros.messages.message_schema import rihs_hash, schema_text
from launcher.ros.snapshot.ros_graph import Direction
from tests.support.foxglove_client import SUBPROTOCOL, FoxgloveClient, cdr, connected, texts
from tests.support.foxglove_server import serving
from tests.support.json_forms import fit
from tests.support.ros_domain import ros_domain
from tests.support.verbs import TIMEOUT_S, launcher
from tests.support.waiting import rest_of, wait_until


@contextlib.contextmanager
def slow_client(url: str, channel: dict[str, Any]) -> Iterator[ClientConnection]:
    """It has subscribed, and reads only on request: answers to pings would be late."""
    with connect(
        url, subprotocols=[SUBPROTOCOL], max_size=None, close_timeout=1, ping_interval=None
    ) as socket:
        subscription = {"id": 1, "channelId": channel["id"]}
        socket.send(json.dumps({"op": "subscribe", "subscriptions": [subscription]}))
        yield socket


class Large:
    """A topic of large messages: one after the other, when the reader has the last one."""

    BYTES = 1_000_000

    def __init__(self, publisher: FoxgloveClient, reader: FoxgloveClient) -> None:
        self._publisher, self._reader = publisher, reader
        self._channel = publisher.advertise("/large", "std_msgs/msg/UInt8MultiArray")
        self._received = reader.subscribe("/large")
        empty = bytes(serialize_message(UInt8MultiArray()))

        def arrives() -> object:
            publisher.publish(self._channel, empty)
            return self._received.messages

        reader.wait(arrives, "the first message")

    def send(self, number: int) -> None:
        message = UInt8MultiArray(data=bytes([number]) * self.BYTES)
        self._publisher.publish(self._channel, bytes(serialize_message(message)))
        self._reader.wait(lambda: self.numbers[-1:] == [number], f"message {number}")

    @property
    def numbers(self) -> list[int]:
        return [p[-1] for _, p in list(self._received.messages) if len(p) > self.BYTES]


def test_a_client_that_does_not_read_loses_messages_and_holds_up_nobody(tmp_path: Path):
    count = 60  # more megabytes than all buffers on the way to the slow client hold
    with (
        ros_domain(tmp_path) as env,
        serving(env, "--queue", "4") as server,
        connected(server.url) as publisher,
        connected(server.url) as reader,
    ):
        large = Large(publisher, reader)
        with slow_client(server.url, reader.channel("/large")) as slow:
            for number in range(count):
                large.send(number)
            assert large.numbers == list(range(count))
            got: list[int] = []
            notice = ""
            while not (notice and count - 1 in got):
                message = slow.recv(timeout=TIMEOUT_S)
                if isinstance(message, bytes) and len(message) > large.BYTES:
                    got.append(message[-1])
                elif isinstance(message, str) and '"status"' in message:
                    notice = json.loads(message)["message"]
        assert got == sorted(set(got))
        assert len(got) < count
        assert "messages were dropped: this client reads too slowly" in notice


@pytest.mark.thorough
def test_it_ends_although_a_client_does_not_read(tmp_path: Path):
    with (
        ros_domain(tmp_path) as env,
        serving(env, "--queue", "4") as server,
        connected(server.url) as publisher,
        connected(server.url) as reader,
    ):
        large = Large(publisher, reader)
        with slow_client(server.url, reader.channel("/large")):
            for number in range(30):
                large.send(number)
            assert server.end()[1] == ""
            assert server.process.returncode == 0


@pytest.mark.thorough
def test_topics_are_chosen(env: dict[str, str]):
    words = ("--topics", "chatter|secret|weak", "--exclude", "^/w", "--hidden")
    with serving(env, *words) as server, connected(server.url) as client:
        client.channel("/_secret")
        client.channel("/chatter")
        assert set(client.channels) == {"/chatter", "/_secret"}


@pytest.mark.thorough
def test_a_read_only_server_only_shows(env: dict[str, str]):
    with serving(env, "--read-only") as server, connected(server.url) as client:
        assert "clientPublish" not in client.info["capabilities"]
        assert "services" not in client.info["capabilities"]
        received = client.subscribe("/chatter")
        client.wait(lambda: received.messages, "a message")
        client.wait(lambda: "/talker.speed" in client.get_parameters(), "parameters")
        client.advertise("/mine", "std_msgs/msg/String")
        client.send("setParameters", parameters=[{"name": "/talker.speed", "value": 1.0}], id="1")
        assert "read-only" in client.call_raw(1, "cdr", b"")
        client.wait(lambda: len(client.statuses) >= 2, "the refusals")
        for what in ("publish", "set parameters"):
            assert f"clients cannot {what}: the server is read-only" in texts(client)
        assert not client.services


@pytest.mark.thorough
@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_it_ends_in_order(env: dict[str, str], signum: int):
    with serving(env) as server:
        client = FoxgloveClient(server.url)
        received = client.subscribe("/chatter")
        client.wait(lambda: received.messages, "a message")
        server.process.send_signal(signum)
        out, err = rest_of(server.process, TIMEOUT_S)
        assert server.process.returncode == 0
        assert err == ""
        lines = "\n".join(line for line in out.splitlines() if line.startswith("{"))
        events = [one["event"] for one in fit("foxglove", lines)]
        assert events == ["connected", "disconnected"]
        client.wait(lambda: client.is_closed, "the end of the connection")


@pytest.mark.thorough
def test_a_port_in_use_is_told(env: dict[str, str]):
    with serving(env) as server:
        port = server.url.rpartition(":")[2]
        answer = launcher(env, "foxglove", "--port", port)
    assert answer.err == (
        f"port {port} of 127.0.0.1 is in use\n"
        f"hint: another foxglove may be running; for another port: --port {int(port) + 1}\n"
    )
    assert (answer.out, answer.code) == ("", 1)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("words", "problem", "code"),
    [
        (["--topics", "("], "--topics: '(' is no regular expression", 1),
        (["--host", "nowhere.invalid"], "there is no address for the host 'nowhere.invalid'", 1),
        (["--host", "192.0.2.1"], "cannot listen on port 8765 of 192.0.2.1: ", 1),
        (["--port", "70000"], "'70000' is not a whole number from 0 to 65535", 2),
        (["--queue", "0"], "'0' is not a number of megabytes", 2),
    ],
)
def test_mistakes_on_the_command_line(env: dict[str, str], words, problem, code):
    answer = launcher(env, "foxglove", *words)
    assert problem in answer.err and answer.code == code
    assert "Traceback" not in answer.err


def test_without_the_extra_the_command_that_installs_it_is_told(
    env: dict[str, str], tmp_path: Path
):
    (tmp_path / "websockets.py").touch()  # as an old one, without `asyncio.server`
    answer = launcher({**env, "PYTHONPATH": str(tmp_path)}, "foxglove")
    assert answer.code == ExitCode.USAGE
    assert "error: foxglove needs the Python package 'websockets', which " in answer.err
    assert "[foxglove]" in answer.err


def test_the_client_of_these_tests_understands_the_server_of_the_sdk():
    """So that client and server cannot misunderstand the protocol in the same way."""
    schema = foxglove.Schema(
        name="std_msgs/msg/String",
        encoding="ros2msg",
        data=schema_text("std_msgs/msg/String").encode(),
    )
    empty = foxglove.Schema(name="std_srvs/srv/Trigger_Request", encoding="ros2msg", data=b"")
    filled = foxglove.Schema(
        name="std_srvs/srv/Trigger_Response",
        encoding="ros2msg",
        data=schema_text("std_srvs/srv/Trigger_Response").encode(),
    )
    answer = bytes(serialize_message(Trigger.Response(success=True, message="reference")))
    service = foxglove.Service(
        "/trigger",
        schema=foxglove.ServiceSchema(
            "std_srvs/srv/Trigger",
            request=foxglove.MessageSchema(encoding="cdr", schema=empty),
            response=foxglove.MessageSchema(encoding="cdr", schema=filled),
        ),
        handler=lambda request: answer,
    )
    context = foxglove.Context()
    server = foxglove.start_server(
        port=0,
        context=context,
        capabilities=[Capability.Services],
        supported_encodings=["cdr"],
        services=[service],
    )
    try:
        topic = foxglove.Channel("/t", schema=schema, message_encoding="cdr", context=context)
        with connected(f"ws://127.0.0.1:{server.port}") as client:
            received = client.subscribe("/t")
            client.wait(lambda: topic.log(cdr("reference")) or received.messages, "a message")
            assert received.decoded()[0].data == "reference"
            assert client.call("/trigger", {}).message == "reference"
            assert set(client.info) >= {"name", "capabilities", "supportedEncodings", "sessionId"}
    finally:
        server.stop()


def test_types_of_the_graph_have_the_installed_hash(observer: Observer):
    wait_until(lambda: observer.infos("/points", Direction.PUBLISHER), "the publisher is known")
    infos = observer.infos("/points", Direction.PUBLISHER)
    assert rihs_hash("geometry_msgs/msg/PointStamped") in infos[0].type_hash
