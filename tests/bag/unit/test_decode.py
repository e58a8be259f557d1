"""Messages of every installed type, decoded by the definition that a bag has."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings

pytest.importorskip("rclpy")

from rclpy.serialization import serialize_message

from launcher.bag.agreement import normalized
from launcher.bag.bag_model import Definition, Topic
from launcher.bag.decode import decoder, plain
from launcher.ros.messages.interfaces import all_interfaces, class_of, definition_path
from launcher.ros.messages.message_schema import schema_text
from launcher.ros.verb import to_json_plain
from tests.support.any_message import messages, same
from tests.support.examples import examples

SEPARATOR = "=" * 80
MESSAGES = all_interfaces(["msg"])
PADDING = "structure_needs_at_least_one_member"
PARTS = [
    "std_srvs/srv/Empty_Request",
    "std_srvs/srv/Trigger_Request",
    "std_srvs/srv/SetBool_Event",
    "rcl_interfaces/srv/SetParameters_Event",
]


def decoded(topic: Topic, message: Any) -> Any:
    return plain(decoder(topic)(serialize_message(message)))


def expected(value: Any) -> Any:
    """As `plain` has it: bytes are numbers."""
    if hasattr(value, "SLOT_TYPES"):
        names = value.get_fields_and_field_types()
        return {name: expected(getattr(value, name)) for name in names if name != PADDING}
    if isinstance(value, bytes):
        return value[0] if len(value) == 1 else list(value)
    if hasattr(value, "tolist"):
        value = value.tolist()
    return [expected(one) for one in value] if isinstance(value, list | tuple) else value


def topic_of(name: str) -> Topic:
    return Topic(name="/t", type=name, definition=Definition(text=schema_text(name)))


@pytest.mark.parametrize("name", [*MESSAGES, *PARTS])
def test_a_message_is_what_was_serialized(name: str):
    check_round_trip(topic_of(name))


@pytest.mark.parametrize("service", all_interfaces(["srv"]))
def test_an_event_by_the_text_that_rosbag2_writes(service: str):
    """That of the .srv, and of the messages that it needs."""
    needed: dict[str, str] = {}
    for part in ("_Request", "_Response"):
        for section in schema_text(f"{service}{part}").split(f"\n{SEPARATOR}\n")[1:]:
            needed[section.partition("\n")[0]] = section
    own = definition_path(service).with_suffix(".srv").read_text()
    text = f"\n{SEPARATOR}\n".join([f"{SEPARATOR}\nSRV: {service}\n{own}", *needed.values()])
    topic = Topic(
        name="/t",
        type=f"{service}_Event",
        definition=Definition(text=text, encoding="ros2msg" if needed else "unknown"),
    )
    check_round_trip(normalized(topic))


def check_round_trip(topic: Topic) -> None:
    name = topic.type

    @settings(max_examples=examples(2), suppress_health_check=list(HealthCheck))
    @given(messages(class_of(*name.split("/"))))
    def round_trip(message: Any) -> None:
        found = decoded(topic, message)
        assert same(found, to_json_plain(expected(message))), found

    round_trip()
