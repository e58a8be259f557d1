"""Parts of the server for Foxglove: the protocol, what waits for clients, what they are told."""

from __future__ import annotations

import json
import struct
from dataclasses import replace
from typing import cast

import pytest

pytest.importorskip("rclpy")

from rcl_interfaces.msg import ParameterEvent

from launcher.base.ros_errors import VerbError
from launcher.ros import parameter_values
from launcher.ros.discovery.observer import Observer
from launcher.ros.foxglove import client_session, protocol
from launcher.ros.foxglove.catalogue import Catalogue
from launcher.ros.foxglove.client_session import ClientOutbox
from launcher.ros.foxglove.graph_view import Connections, TopicChoice, look
from launcher.ros.foxglove.parameter_services import changed_by, to_json, to_parameter
from launcher.ros.foxglove.protocol import ClientData, ProtocolError, ServiceCall
from launcher.ros.snapshot.ros_graph import Endpoint, EndpointInfo

NOTHING = Connections()


def taken(box: ClientOutbox) -> list[str | bytes]:
    return list(iter(box.take, None))


def data(*numbers: int, payload: bytes = b"12345678") -> list[bytes]:
    return [protocol.message_data(1, number, payload) for number in numbers]


def test_the_oldest_data_is_dropped_where_it_does_not_fit():
    box = ClientOutbox(24)
    for number in range(10):
        box.put_data(1, number, b"12345678")
    assert taken(box) == data(7, 8, 9)
    assert (box.take_dropped(), box.take_dropped()) == (7, 0)


def test_data_above_the_bound_is_sent_if_it_is_alone():
    box = ClientOutbox(4)
    box.put_data(1, 0, b"12345678")
    assert taken(box) == data(0)
    box.put_data(1, 1, b"12345678")
    box.put_data(1, 2, b"12345678")
    assert taken(box) == data(2)


def test_other_messages_overtake_data_and_are_never_dropped():
    box = ClientOutbox(16)
    for number in range(5):
        box.put_data(1, number, b"12345678")
        box.put(f"message {number}")
    assert taken(box) == [*(f"message {number}" for number in range(5)), *data(3, 4)]


def test_only_an_idle_taker_is_woken():
    box = ClientOutbox(100)
    assert box.put_data(1, 0, b"x")
    assert not box.put("text")
    assert not box.put_data(1, 1, b"x")
    assert box.take() == "text"
    assert not box.put("text")
    taken(box)
    assert box.put("text")


def test_data_of_an_ended_subscription_is_forgotten():
    box = ClientOutbox(1000)
    for number in range(4):
        box.put_data(number % 2, number, b"12345678")
    box.forget(0)
    assert taken(box) == data(1, 3)


def test_a_client_that_does_not_even_take_other_messages_is_lost(monkeypatch):
    monkeypatch.setattr(client_session, "CONTROL_BYTES", 10)
    box = ClientOutbox(100)
    box.put("123456")
    assert not box.is_overfull
    box.put("123456")
    assert box.is_overfull
    box.put("more")
    assert taken(box) == ["123456", "123456"]


def test_binary_messages_of_clients():
    message = struct.pack("<BI", 1, 7) + b"payload"
    assert protocol.parse_data(message) == ClientData(7, b"payload")
    call = struct.pack("<BIII", 2, 3, 4, 3) + b"cdrpayload"
    assert protocol.parse_data(call) == ServiceCall(3, 4, "cdr", b"payload")
    answer = protocol.service_response(ServiceCall(3, 4, "cdr", b""), b"answer")
    assert answer == struct.pack("<BIII", 3, 3, 4, 3) + b"cdranswer"


@pytest.mark.parametrize(
    "message",
    [b"", b"\1", b"\1abc", b"\2", b"\2" + b"\xff" * 12, struct.pack("<BIII", 2, 1, 1, 1) + b"\xff"],
)
def test_bad_binary_messages(message: bytes):
    with pytest.raises(ProtocolError, match="invalid message: "):
        protocol.parse_data(message)


@pytest.mark.parametrize("message", ["", "[]", "{}", '{"op": 1}', "[" * 100_000])
def test_bad_texts(message: str):
    with pytest.raises(ProtocolError, match="invalid message: "):
        protocol.parse_text(message)


def test_bad_fields():
    for value in (None, "x", [True], [-1], [2**32], ["1"], [1.5]):
        with pytest.raises(ProtocolError, match="'ids' must be"):
            protocol.numbers({"ids": value}, "ids")
    for value in (None, "x", [1]):
        with pytest.raises(ProtocolError, match="'names' must be"):
            protocol.strings({"names": value}, "names")
    for value in ([1], [{}], [{"id": 1}], [{"id": 1, "topic": 2}], [{"id": "1", "topic": "x"}]):
        with pytest.raises(ProtocolError, match=r"invalid message: 'channels"):
            protocol.objects({"channels": value}, "channels", id=int, topic=str)
    with pytest.raises(ProtocolError, match="'id' must be a string"):
        protocol.identifier({"id": 1})


def test_what_is_not_set_is_left_out():
    assert json.loads(protocol.text("x", id=None, parameters=[])) == {"op": "x", "parameters": []}


def test_the_update_of_connections_leads_from_one_state_to_the_next():
    before = Connections(
        published={"/a": ("/n",), "/b": ("/n",), "/c": ("/n",)},
        subscribed={"/a": ("/m",), "/d": ("/m",)},
        services={"/s": ("/n",), "/t": ("/n",)},
    )
    after = Connections(
        published={"/b": ("/n", "/o"), "/c": ("/n",)},
        subscribed={"/a": ("/m",)},
        services={"/t": ("/o",)},
    )
    assert after.update_from(before) == {
        "publishedTopics": [
            {"name": "/a", "publisherIds": []},
            {"name": "/b", "publisherIds": ["/n", "/o"]},
        ],
        "subscribedTopics": [],
        "advertisedServices": [{"name": "/t", "providerIds": ["/o"]}],
        "removedTopics": ["/d"],
        "removedServices": ["/s"],
    }
    assert after.update_from(after) is None
    first = after.update_from(NOTHING)
    assert first is not None and len(first["publishedTopics"]) == 2
    assert NOTHING.update_from(NOTHING) is None


class Discovery:
    """Knows one topic: a subscription whose node has no name yet, and a ghost's."""

    def ghosts(self) -> tuple[str, ...]:
        return ("/gone",)

    def topic_types(self) -> dict[str, list[str]]:
        return {"/a": ["std_msgs/msg/String"]}

    def node_names(self) -> list[str]:
        return ["/talker"]

    def services_of(self, node: str) -> list[tuple[str, list[str]]]:
        return []

    def endpoints(self, topic: str) -> list[Endpoint]:
        publisher = EndpointInfo(
            topic="rt/a",
            type="std_msgs::msg::dds_::String_",
            node="/talker",
            direction="publisher",
            reliability="RELIABLE",
            durability="VOLATILE",
        )
        others = [replace(publisher, direction="subscription", node=node) for node in ("", "/gone")]
        return [info.endpoint() for info in (publisher, *others)]


def test_connections_have_no_node_before_its_name_is_known():
    discovery = cast(Observer, Discovery())
    found = look(discovery, TopicChoice(), (), with_connections=True)
    assert found.connections == Connections(published={"/a": ("/talker",)})


class Schemas:
    """Knows every type but those whose name has an X."""

    def __init__(self) -> None:
        self.warnings: list[str] = []
        self.catalogue = Catalogue(self._schema, self.warnings.append)

    def _schema(self, type_name: str) -> str:
        if "X" in type_name:
            raise VerbError(f"no definition of {type_name} is installed")
        return f"# {type_name}"


def test_channels_come_and_go_under_new_numbers():
    catalogue = Schemas().catalogue
    first = catalogue.update({"/a": ("p/msg/A",), "/b": ("p/msg/B",)}, {})
    assert [(one.topic, one.schema) for one in first.channels] == [
        ("/a", "# p/msg/A"),
        ("/b", "# p/msg/B"),
    ]
    second = catalogue.update({"/b": ("p/msg/C",)}, {})
    assert [one.topic for one in second.gone_channels] == ["/a", "/b"]
    assert [(one.topic, one.type) for one in second.channels] == [("/b", "p/msg/C")]
    ids = [one.id for one in [*first.channels, *second.channels]]
    assert len(set(ids)) == 3
    assert catalogue.channel(ids[0]) is None
    assert catalogue.channel(ids[2]) is second.channels[0]
    third = catalogue.update({"/b": ("p/msg/C",)}, {})
    assert not third.channels and not third.gone_channels


def test_a_topic_with_two_types_is_shown_once_with_a_warning():
    schemas = Schemas()
    topics = {"/a": ("p/msg/X", "p/msg/B", "p/msg/C")}
    change = schemas.catalogue.update(topics, {})
    assert [one.type for one in change.channels] == ["p/msg/B"]
    assert not schemas.catalogue.update(topics, {}).channels
    assert schemas.warnings == [
        "/a is not shown: no definition of p/msg/X is installed",
        "/a is shown as p/msg/B, and not as p/msg/X, p/msg/C",
    ]


def test_what_is_not_installed_is_told_once():
    schemas = Schemas()
    for _ in range(3):
        change = schemas.catalogue.update({"/a": ("p/msg/X",)}, {"/s": "p/srv/X", "/t": "p/srv/S"})
    assert not schemas.catalogue.channels
    assert [one.name for one in schemas.catalogue.services] == ["/t"]
    assert not change.services
    assert len(schemas.warnings) == 3  # a topic, a request and a response


def test_services_have_their_schemas():
    change = Schemas().catalogue.update({}, {"/s": "p/srv/S"})
    offered = change.services[0].to_json()
    assert offered["request"] == {
        "encoding": "cdr",
        "schemaName": "p/srv/S_Request",
        "schemaEncoding": "ros2msg",
        "schema": "# p/srv/S_Request",
    }
    assert offered["responseSchema"] == "# p/srv/S_Response"


def test_a_choice_of_topics():
    choice = TopicChoice(topics="^/fleet|camera", exclude="raw$")
    assert [t for t in ("/fleet/a", "/x/camera", "/x", "/camera/raw") if choice.has(t)] == [
        "/fleet/a",
        "/x/camera",
    ]
    assert not TopicChoice().has("/_secret") and TopicChoice(hidden=True).has("/_secret")
    with pytest.raises(VerbError, match=r"--exclude: '\(' is no regular expression: "):
        TopicChoice(exclude="(").check()


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (True, {"value": True}),
        (3, {"value": 3}),
        (2.0, {"value": 2.0, "type": "float64"}),
        (float("nan"), {"value": "nan", "type": "float64"}),
        ("text", {"value": "text"}),
        ([True, False], {"value": [True, False]}),
        ([1, 2], {"value": [1, 2]}),
        ([1.0, 2.5], {"value": [1.0, 2.5], "type": "float64_array"}),
        (["a"], {"value": ["a"]}),
    ],
)
def test_parameters_are_shown_and_set_as_they_are_shown(value, shown):
    parameter = parameter_values.parameter("p", value)
    item = to_json("/n.p", parameter.value)
    assert item == {"name": "/n.p", **shown}
    assert repr(to_parameter("p", item, 0)) == repr(parameter)


def test_bytes_are_base64():
    parameter = parameter_values.parameter("p", [0, 255], parameter_values.BYTES)
    item = to_json("/n.p", parameter.value)
    assert item == {"name": "/n.p", "value": "AP8=", "type": "byte_array"}
    assert to_parameter("p", item, 0) == parameter


def test_a_parameter_without_a_value():
    unset = to_parameter("p", {"name": "/n.p"}, parameter_values.DOUBLE)
    assert unset.value.type == 0
    assert to_json("/n.p", unset.value) == {"name": "/n.p"}


def test_a_whole_number_for_a_double_is_one():
    assert to_parameter("p", {"value": 2}, parameter_values.DOUBLE).value.double_value == 2.0


@pytest.mark.parametrize(
    ("item", "problem"),
    [
        ({"value": "!", "type": "byte_array"}, "the value is no byte_array"),
        ({"value": [1], "type": "float64"}, "the value is no float64"),
        ({"value": 5, "type": "float64_array"}, "the value is no float64_array"),
        ({"value": {"a": 1}}, "cannot hold"),
        ({"value": [1, "a"]}, "cannot hold"),
        ({"value": 2**64}, "cannot hold"),
    ],
)
def test_values_that_parameters_cannot_have(item, problem):
    with pytest.raises(VerbError, match=problem):
        to_parameter("p", item, 0)


def test_an_event_tells_what_has_changed():
    event = ParameterEvent(
        node="/n",
        new_parameters=[parameter_values.parameter("a", 1)],
        changed_parameters=[parameter_values.parameter("b", 2.0)],
        deleted_parameters=[parameter_values.parameter("c", "gone")],
    )
    assert changed_by(event) == [
        {"name": "/n.a", "value": 1},
        {"name": "/n.b", "value": 2.0, "type": "float64"},
        {"name": "/n.c"},
    ]
