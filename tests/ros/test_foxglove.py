"""`foxglove`: a client of its protocol sees, and changes, real nodes."""

from __future__ import annotations

import contextlib
import json
import signal
import subprocess
import sys
import tempfile
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import foxglove
import pytest
from foxglove.websocket import Capability
from rclpy.serialization import serialize_message
from std_msgs.msg import String, UInt8MultiArray
from std_srvs.srv import Trigger
from websockets.exceptions import InvalidStatus
from websockets.sync.client import ClientConnection, connect

from launcher.ros.discovery.observer import Observer
from launcher.ros.messages.schema import rihs_hash, schema_text
from launcher.ros.snapshot.graph import Direction
from tests.ros.conftest import ros_domain
from tests.ros.test_bridge import SLEEPERS, run_of
from tests.support.foxglove_client import SUBPROTOCOL, FoxgloveClient, connected
from tests.support.node_process import without_complaints
from tests.support.verbs import TIMEOUT_S, going_on, launcher
from tests.support.waiting import wait_until


class Server:
    """A running `foxglove` and what it has printed."""

    def __init__(self, env: Mapping[str, str], *words: str) -> None:
        command = [sys.executable, "-m", "launcher", "foxglove", "--port", "0", "--json", *words]
        self.process = subprocess.Popen(
            command, env=dict(env), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        self.events = []
        for line in self.process.stdout:
            if line.startswith("{"):  # Fast DDS may complain of a port
                self.events.append(json.loads(line))
                break
        self.url = self.events[0]["url"]

    def end(self) -> tuple[str, str]:
        """Ctrl-C; what it printed after the start, on both streams."""
        self.process.send_signal(signal.SIGINT)
        return self.process.communicate(timeout=TIMEOUT_S)


@contextlib.contextmanager
def serving(env: Mapping[str, str], *words: str) -> Iterator[Server]:
    server = Server(env, *words)
    try:
        yield server
    finally:
        if server.process.poll() is None:
            server.end()


@pytest.fixture(scope="module")
def server(env: dict[str, str]) -> Iterator[Server]:
    """It serves the domain of the sample nodes."""
    with serving(env) as server:
        yield server


@pytest.fixture
def client(server: Server) -> Iterator[FoxgloveClient]:
    with connected(server.url) as client:
        yield client


def cdr(text: str) -> bytes:
    return bytes(serialize_message(String(data=text)))


def texts(client: FoxgloveClient) -> str:
    return "\n".join(status["message"] for status in client.statuses)


def listeners(observer: Observer, topic: str) -> list[str]:
    """Subscriptions of hidden nodes, as the server's is."""
    infos = observer.infos(topic, Direction.SUBSCRIPTION)
    return [info.node for info in infos if "/_launcher" in info.node]


def test_the_server_introduces_itself(client: FoxgloveClient, env: dict[str, str]):
    assert client.socket.subprotocol == SUBPROTOCOL
    assert client.info["name"] == f"ROS domain {env['ROS_DOMAIN_ID']}"
    assert set(client.info["capabilities"]) == {
        *("clientPublish", "services", "connectionGraph", "parameters", "parametersSubscribe")
    }
    assert client.info["supportedEncodings"] == ["cdr", "json"]
    assert client.info["metadata"]["ROS_DISTRO"] == "jazzy"


@pytest.mark.thorough
def test_older_clients_are_served_and_others_refused(server: Server):
    with connected(server.url, "foxglove.websocket.v1") as client:
        assert client.socket.subprotocol == "foxglove.websocket.v1"
    with pytest.raises(InvalidStatus), connect(server.url, subprotocols=["something.else"]):
        pass
    with pytest.raises(urllib.error.HTTPError):
        urllib.request.urlopen(server.url.replace("ws:", "http:"), timeout=TIMEOUT_S)


def test_topics_are_channels_with_the_definition_of_their_type(client: FoxgloveClient):
    channel = client.channel("/points")
    assert channel["schemaName"] == "geometry_msgs/msg/PointStamped"
    assert (channel["encoding"], channel["schemaEncoding"]) == ("cdr", "ros2msg")
    assert channel["schema"] == schema_text("geometry_msgs/msg/PointStamped")
    assert "/_secret" not in client.channels


def test_the_bytes_of_messages_arrive_as_they_were_sent(client: FoxgloveClient):
    received, points = client.subscribe("/chatter"), client.subscribe("/points")
    client.wait(lambda: len(received.messages) >= 3 and points.messages, "messages")
    numbers = [int(message.data.removeprefix("msg ")) for message in received.decoded()]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    # on its way DDS pads them
    assert received.messages[0][1].rstrip(b"\0") == cdr(f"msg {numbers[0]}").rstrip(b"\0")
    times = [time_ns for time_ns, _ in received.messages]
    assert times == sorted(times)
    point = points.decoded()[0]
    assert (point.header.frame_id, point.point.x) == ("map", 0.5)


def test_best_effort_publishers_are_heard(client: FoxgloveClient):
    received = client.subscribe("/weak")
    client.wait(lambda: received.messages, "a message")


def test_each_client_gets_what_publishers_keep_for_those_who_come_late(server: Server):
    for _ in range(2):
        with connected(server.url) as one, connected(server.url) as other:
            first = one.subscribe("/latched")
            one.wait(lambda first=first: len(first.messages) >= 5, "the backlog")
            second = other.subscribe("/latched")
            other.wait(lambda second=second: len(second.messages) >= 5, "the backlog")
            for received in (first, second):
                assert [message.data for message in received.decoded()] == [3, 4, 5, 6, 7]


def test_a_subscription_exists_while_a_client_wants_it(server: Server, observer: Observer):
    topic = "/numbers"
    with connected(server.url) as one, connected(server.url) as other:
        assert listeners(observer, topic) == []
        first, second = one.subscribe(topic), other.subscribe(topic)
        one.wait(lambda: first.messages and second.messages, "messages")
        wait_until(lambda: len(listeners(observer, topic)) == 1, "they share a subscription")
        one.unsubscribe(first)
        count = len(second.messages)
        other.wait(lambda: len(second.messages) > count + 2, "more messages")
        assert len(listeners(observer, topic)) == 1
    wait_until(lambda: not listeners(observer, topic), "the last client has gone")


def test_topics_appear_and_vanish(client: FoxgloveClient, env: dict[str, str]):
    pub = ("topic", "pub", "/sometimes", "std_msgs/msg/String", "data: here", "-r", "10")
    with going_on(env, *pub):
        received = client.subscribe("/sometimes")
        client.wait(lambda: received.messages, "a message")
    client.wait(lambda: "/sometimes" not in client.channels, "the channel has gone")
    number, count = received.channel["id"], len(received.messages)
    with going_on(env, *pub):
        client.wait(lambda: len(received.messages) > count, "a message of the new publisher")
    assert received.channel["id"] != number


@pytest.mark.thorough
def test_a_subscription_is_fitted_to_publishers_that_come_later(
    server: Server, env: dict[str, str]
):
    """Of a topic that has only a subscription the QoS is not known."""
    with (
        going_on(env, "topic", "echo", "/late", "std_msgs/msg/String"),
        connected(server.url) as client,
    ):
        received = client.subscribe("/late")
        pub = ("topic", "pub", "/late", "std_msgs/msg/String", "data: kept", "--once")
        kept = ("--qos-durability", "transient_local", "--keep-alive", "60")
        with going_on(env, *pub, *kept):
            client.wait(lambda: received.messages, "the message")
            assert received.decoded()[0].data == "kept"


@pytest.mark.parametrize(
    ("encoding", "kind"), [("cdr", "std_msgs/msg/String"), ("json", "std_msgs/String")]
)
def test_clients_publish(client: FoxgloveClient, env: dict[str, str], encoding: str, kind: str):
    topic = f"/from_{encoding}"
    words = ("topic", "echo", topic, "std_msgs/msg/String", "--csv", "--once")
    echo = subprocess.Popen(
        [sys.executable, "-m", "launcher", *words], env=env, stdout=subprocess.PIPE, text=True
    )
    number = client.advertise(topic, kind, encoding)
    payload = cdr("grüße") if encoding == "cdr" else '{"data": "grüße"}'.encode()

    def is_heard() -> bool:
        client.publish(number, payload)
        return echo.poll() is not None

    wait_until(is_heard, "a message that the subscription was there for")
    assert without_complaints(echo.communicate()[0]) == "grüße\n"
    assert not client.statuses


def test_clients_hear_each_other(server: Server):
    with connected(server.url) as one, connected(server.url) as other:
        number = one.advertise("/between_clients", "std_msgs/msg/String")
        received = other.subscribe("/between_clients")
        other.wait(lambda: one.publish(number, cdr("hello")) or received.messages, "a message")
        one.send("unadvertise", channelIds=[number])
        other.wait(lambda: "/between_clients" not in other.channels, "the channel has gone")


def test_mistakes_of_clients_are_told(client: FoxgloveClient):
    number = client.advertise("/mistakes", "std_msgs/msg/String")
    as_json = client.advertise("/mistakes", "std_msgs/msg/String", "json")
    client.publish(number, b"\0\1\0\0\4\0")
    client.publish(as_json, b'{"dat": "x"}')
    client.publish(as_json, b"not json")
    client.publish(12345, b"")
    client.advertise("/mistakes", "std_msgs/msg/Strin")
    client.advertise("/mist akes", "std_msgs/msg/String")
    client.advertise("/mistakes", "std_msgs/msg/String", "protobuf")
    client.send("subscribe", subscriptions=[{"id": 1, "channelId": 12345}])
    client.send("nonsense")
    client.socket.send(b"")
    client.wait(lambda: len(client.statuses) >= 10, "an answer to each")
    for text in (
        "/mistakes: no String: failed to deserialize ROS message",
        "/mistakes: Failed to populate field: 'String' object has no attribute 'dat'",
        "/mistakes: no String: Expecting value",
        "channel 12345 is not advertised by this client",
        "did you mean String?",
        "/mist akes: Invalid topic name",
        "encoding 'protobuf' cannot be published; cdr and json can",
        "there is no channel 12345",
        "unknown op 'nonsense'",
        "no binary message has the opcode None",
    ):
        assert text in texts(client)
    client.publish(number, cdr("still served"))
    received = client.subscribe("/chatter")
    client.wait(lambda: received.messages, "a message")


def test_another_type_for_a_topic_is_refused(client: FoxgloveClient):
    received = client.subscribe("/chatter")
    client.wait(lambda: received.messages, "a message")
    client.advertise("/chatter", "std_msgs/msg/Int32")
    client.wait(lambda: "/chatter: cannot publish: " in texts(client), "the refusal")
    count = len(received.messages)
    client.wait(lambda: len(received.messages) > count, "more messages")


def test_services_are_called(client: FoxgloveClient):
    answer = client.call("/switch", {"data": True})
    assert (answer.success, answer.message) == (True, "on")
    service = client.services["/switch"]
    assert service["type"] == "std_srvs/srv/SetBool"
    assert service["request"]["schema"].startswith("bool data")
    as_json = client.call_raw(service["id"], "json", b'{"data": false}')
    assert as_json == ("json", b'{"success": false, "message": "off"}')


def test_failed_calls_are_told(client: FoxgloveClient):
    client.wait(lambda: "/switch" in client.services, "the service")
    number = client.services["/switch"]["id"]
    assert "no request of std_srvs/srv/SetBool" in client.call_raw(number, "cdr", b"")
    assert "data" in client.call_raw(number, "json", b'{"data": 5}')
    assert client.call_raw(number, "xml", b"") == "unknown encoding 'xml'"
    assert client.call_raw(54321, "cdr", b"") == "there is no service 54321"


@pytest.mark.thorough
def test_a_slow_service_holds_up_nothing(client: FoxgloveClient):
    client.wait(lambda: "/occupy" in client.services, "the service")
    done = threading.Event()
    caller = threading.Thread(target=lambda: client.call("/occupy", {}) and done.set())
    caller.start()
    received = client.subscribe("/parameter_events")
    client.advertise("/meanwhile", "std_msgs/msg/String")
    client.wait(lambda: "/meanwhile" in client.channels, "a new channel")
    caller.join()
    assert done.is_set() and received is not None


def test_parameters_of_all_nodes_are_read(client: FoxgloveClient):
    client.wait(lambda: "/talker.speed" in client.get_parameters(), "the parameters of the talker")
    found = client.get_parameters()
    assert found["/talker.tags"]["value"] == ["a", "b"]
    assert found["/talker.speed"]["type"] == "float64"
    assert found["/site/east/listener.use_sim_time"] == {
        "name": "/site/east/listener.use_sim_time",
        "value": False,
    }
    some = client.get_parameters("/talker.tags", "/talker.missing", "/nobody.x", "nonsense")
    assert list(some) == ["/talker.tags"]


def test_parameters_are_set_within_their_limits(client: FoxgloveClient):
    client.wait(lambda: "/talker.speed" in client.get_parameters(), "the parameters of the talker")
    try:
        found = client.set_parameters({"name": "/talker.speed", "value": 1})
        assert found["/talker.speed"]["value"] == 1.0
        found = client.set_parameters({"name": "/talker.speed", "value": 7.5, "type": "float64"})
        assert found["/talker.speed"]["value"] == 1.0
        client.wait(lambda: "/talker.speed: " in texts(client), "the reason")
        client.set_parameters({"name": "/nobody.x", "value": 1})
        client.wait(lambda: "/nobody.x: there is no node /nobody" in texts(client), "the reason")
    finally:
        client.set_parameters({"name": "/talker.speed", "value": 1.5, "type": "float64"})


@pytest.mark.thorough
def test_changes_of_parameters_are_told_to_those_who_want_them(
    server: Server, client: FoxgloveClient, env: dict[str, str]
):
    client.wait(lambda: "/talker.name" in client.get_parameters(), "the parameters of the talker")
    with connected(server.url) as other:
        client.send("subscribeParameterUpdates", parameterNames=["/talker.name"])
        values = iter(range(10**6))

        def is_told() -> bool:
            word = f"name {next(values)}"
            assert launcher(env, "param", "set", "/talker", "name", word).code == 0
            wait_until(lambda: True, "")
            return bool(client.updates("/talker.name"))

        client.wait(is_told, "an update")
        assert client.updates("/talker.name")[-1].startswith("name ")
        assert not other.updates("/talker.name")
        client.send("unsubscribeParameterUpdates", parameterNames=["/talker.name"])
        launcher(env, "param", "set", "/talker", "name", "sample")


def test_the_connections_are_told_and_their_changes(client: FoxgloveClient, env: dict[str, str]):
    def published() -> dict[str, list[str]]:
        updates = [one for update in client.connections for one in update["publishedTopics"]]
        return {one["name"]: one["publisherIds"] for one in updates}

    client.send("subscribeConnectionGraph")
    client.wait(lambda: published().get("/chatter") == ["/talker"], "a publisher")
    update = client.connections[0]
    subscribed = {one["name"]: one["subscriberIds"] for one in update["subscribedTopics"]}
    assert "/site/east/listener" in subscribed["/chatter"]
    provided = {one["name"]: one["providerIds"] for one in update["advertisedServices"]}
    assert provided["/switch"] == ["/talker"]
    with going_on(env, "topic", "pub", "/connected", "std_msgs/msg/String", "-r", "10"):
        client.wait(lambda: "/connected" in published(), "a new publisher")
    client.wait(
        lambda: any("/connected" in update["removedTopics"] for update in client.connections),
        "it has gone",
    )


@pytest.mark.thorough
def test_diagnostics_of_a_run_are_a_topic(tmp_path: Path):
    with (
        tempfile.TemporaryDirectory(prefix="run-", ignore_cleanup_errors=True) as runtime,
        ros_domain(tmp_path) as domain,
    ):
        env = {**domain, "TMPDIR": runtime, "XDG_RUNTIME_DIR": runtime}
        with (
            run_of(env, tmp_path, SLEEPERS) as run,
            serving(env) as server,
            connected(server.url) as client,
        ):
            received = client.subscribe("/diagnostics")

            def names() -> set[str]:
                return {one.name for message in received.decoded() for one in message.status}

            client.wait(
                lambda: {"launcher: left-1", "launcher: right-2"} <= names(), "the processes"
            )
            answer = client.call("/launcher/left/stop", {})
            assert answer.success, answer
            client.wait(lambda: "/launcher/left/start" in client.services, "the services")
            run.process.send_signal(signal.SIGINT)
            run.process.wait()
            client.wait(lambda: "/diagnostics" not in client.channels, "the run has ended")
            client.wait(lambda: "/launcher/left/start" not in client.services, "its services too")


@contextlib.contextmanager
def slow_client(url: str, channel: dict[str, Any]) -> Iterator[ClientConnection]:
    """It has subscribed, and reads only when it is told to."""
    with connect(url, subprotocols=[SUBPROTOCOL], max_size=None, close_timeout=1) as socket:
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
        out, err = server.process.communicate(timeout=TIMEOUT_S)
        assert server.process.returncode == 0
        assert err == ""
        events = [json.loads(line)["event"] for line in out.splitlines() if line.startswith("{")]
        assert events == ["connected", "disconnected"]
        client.wait(lambda: client.is_closed, "the end of the connection")


@pytest.mark.thorough
def test_a_port_in_use_is_told(env: dict[str, str], server: Server):
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
    (tmp_path / "websockets.py").write_text("raise ImportError('not installed')")
    answer = launcher({**env, "PYTHONPATH": str(tmp_path)}, "foxglove")
    assert answer.code == 1
    assert answer.err.startswith("foxglove needs the Python package websockets\nhint: ")
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
