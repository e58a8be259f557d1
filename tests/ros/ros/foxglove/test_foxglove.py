"""`foxglove`: a client of its protocol sees, and changes, real nodes."""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from launcher.packages.distribution import installed
from launcher.ros.discovery.observer import Observer
from launcher.ros.messages.message_schema import schema_text
from launcher.ros.snapshot.ros_graph import Direction
from tests.ros.ros.test_bridge import SLEEPERS, run_of
from tests.support.foxglove_client import SUBPROTOCOL, FoxgloveClient, cdr, connected, texts
from tests.support.foxglove_server import Server, serving
from tests.support.node_process import without_complaints
from tests.support.ros_domain import ros_domain, talking
from tests.support.verbs import TIMEOUT_S, eventually, going_on, launcher
from tests.support.waiting import wait_until


@pytest.fixture(scope="module")
def server(env: dict[str, str]) -> Iterator[Server]:
    """It serves the domain of the sample nodes."""
    with serving(env) as server:
        yield server


@pytest.fixture
def client(server: Server) -> Iterator[FoxgloveClient]:
    with connected(server.url) as client:
        yield client


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
    assert client.info["metadata"]["ROS_DISTRO"] == installed()


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


@pytest.mark.thorough
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
        going_on(
            env, "topic", "echo", "/late", "std_msgs/msg/String", "--qos-reliability", "best_effort"
        ),
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


@pytest.mark.thorough
def test_a_time_that_is_now_is_that_of_sending(server: Server):
    with connected(server.url) as one, connected(server.url) as other:
        number = one.advertise("/stamped", "std_msgs/msg/Header", "json")
        received = other.subscribe("/stamped")
        payload = b'{"stamp": "now", "frame_id": "map"}'
        other.wait(lambda: one.publish(number, payload) or received.messages, "a message")
        assert received.decoded()[0].stamp.sec > 0


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


def test_odd_texts_are_answered_and_the_client_is_still_served(client: FoxgloveClient):
    as_json = client.advertise("/odd", "std_msgs/msg/String", "json")
    for text in (
        "[" * 100_000,
        '{"op": "subscribe", "subscriptions": [{"id": 1e999}]}',
        '{"op": NaN}',
        '{"op": ' + "1" * 5000 + "}",
        '{"op": "\\udcff"}',
    ):
        client.socket.send(text)
    client.advertise("/\udcff", "std_msgs/msg/String")
    client.publish(as_json, b'{"data": "\\udcff"}')
    client.publish(as_json, b"[" * 100_000)
    client.wait(lambda: len(client.statuses) >= 8, "an answer to each")
    for text in (
        "objects and lists are more than 200 deep",
        "1e999 is too large",
        "NaN is not JSON",
        "11111111111111111111... is too large",
        "unknown op '\ufffd'",
        "not UTF-8",
        "/odd: Failed to populate field: 'data' takes a string",
        "/odd: no String: objects and lists",
    ):
        assert text in texts(client)
    client.wait(
        lambda: "/talker.speed" in client.get_parameters("/talker.speed", "\udcff"),
        "an answer of the node, once it is discovered",
    )


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
    found: dict[str, dict] = {}

    def all_answer() -> bool:
        found.update(client.get_parameters())
        return {"/talker.speed", "/site/east/listener.use_sim_time"} <= found.keys()

    client.wait(all_answer, "the parameters of two nodes")
    assert found["/talker.tags"]["value"] == ["a", "b"]
    assert found["/talker.speed"]["type"] == "float64"
    assert found["/site/east/listener.use_sim_time"] == {
        "name": "/site/east/listener.use_sim_time",
        "value": False,
    }
    some = client.get_parameters("/talker.tags", "/talker.missing", "/nobody.x", "nonsense")
    assert list(some) == ["/talker.tags"]


def test_a_parameter_without_a_value_hides_none_of_the_others(
    client: FoxgloveClient, env: dict[str, str]
):
    with talking(env, "tests.support.parameter_node"):
        client.wait(lambda: "/tunable.gears" in client.get_parameters(), "its parameters")
        found = client.wait(lambda: client.get_parameters("/tunable.later"), "the one")
        assert found == {"/tunable.later": {"name": "/tunable.later"}}

        def is_set() -> bool:
            after = client.set_parameters({"name": "/tunable.later", "value": 4})
            return after.get("/tunable.later", {}).get("value") == 4

        client.wait(is_set, "a value for it")


def test_a_node_that_vanishes_leaves_no_request_unanswered(server: Server, env: dict[str, str]):
    with connected(server.url) as client, talking(env, "tests.support.silent_node") as node:
        services = ("/silent/list_parameters", "/silent/get_parameters")
        client.wait(lambda: client.services.keys() >= set(services), "its services")
        client.send("getParameters", id="all", parameterNames=["/silent.a"])
        threading.Timer(0.1, print, ("end",), {"file": node.stdin, "flush": True}).start()
        answer = client.call("/silent/list_parameters", {})
        assert answer == "service '/silent/list_parameters' has vanished before it answered"
        client.wait(lambda: [v for v in client.values if v.get("id") == "all"], "an answer")


def test_parameters_are_set_within_their_limits(client: FoxgloveClient):
    client.wait(lambda: "/talker.speed" in client.get_parameters(), "the parameters of the talker")

    def is_one_after(**wanted: object) -> bool:
        """To be repeated: a node that does not answer in time is left out."""
        found = client.set_parameters({"name": "/talker.speed", **wanted})
        return "/talker.speed" in found and found["/talker.speed"]["value"] == 1.0

    try:
        client.wait(lambda: is_one_after(value=1), "a whole number for it")
        client.wait(lambda: is_one_after(value=7.5, type="float64"), "no value out of range")
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
            setting = ("param", "set", "/talker", "name", word)
            eventually(lambda: launcher(env, *setting), lambda answer: answer.code == 0)
            return bool(client.updates("/talker.name"))

        client.wait(is_told, "an update")
        assert client.updates("/talker.name")[-1].startswith("name ")
        assert not other.updates("/talker.name")
        client.send("unsubscribeParameterUpdates", parameterNames=["/talker.name"])
        launcher(env, "param", "set", "/talker", "name", "sample")


@pytest.mark.thorough
def test_the_connections_are_told_and_their_changes(client: FoxgloveClient, env: dict[str, str]):
    def known(field: str, ids: str) -> dict[str, list[str]]:
        updates = [one for update in client.connections for one in update[field]]
        return {one["name"]: one[ids] for one in updates}

    def published() -> dict[str, list[str]]:
        return known("publishedTopics", "publisherIds")

    def is_complete() -> bool:
        """Names arrive in any order, some of them in a later update."""
        return (
            published().get("/chatter") == ["/talker"]
            and "/site/east/listener"
            in known("subscribedTopics", "subscriberIds").get("/chatter", [])
            and known("advertisedServices", "providerIds").get("/switch") == ["/talker"]
        )

    client.send("subscribeConnectionGraph")
    client.wait(is_complete, "the nodes of a topic and of a service")
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
