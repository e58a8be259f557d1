"""Messages to YAML and back for every installed type, and values that do not fit."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings

pytest.importorskip("rclpy")

from launcher.base.ros_errors import VerbError
from launcher.ros.messages.from_yaml import fill, parse
from launcher.ros.messages.interfaces import (
    all_interfaces,
    full_type,
    load,
    load_message,
    resolve,
)
from launcher.ros.messages.to_yaml import Style, to_csv, to_plain, to_yaml
from launcher.ros.verb import to_json_plain
from tests.support.any_message import messages, same
from tests.support.examples import examples

MESSAGES = all_interfaces(["msg"])
SERVICES = all_interfaces(["srv"])


def test_there_are_many_types_to_try():
    assert len(MESSAGES) > 150
    assert "std_msgs/msg/String" in MESSAGES


@pytest.mark.parametrize("name", MESSAGES)
def test_a_message_survives_the_way_to_yaml_and_back(name):
    cls = load_message(name)

    @settings(max_examples=examples(4), suppress_health_check=list(HealthCheck))
    @given(messages(cls))
    def round_trip(message: Any) -> None:
        again = cls()
        fill(again, parse(to_yaml(message)))
        assert same(to_plain(again), to_plain(message))
        json.dumps(to_json_plain(to_plain(message)), allow_nan=False)
        to_csv(message)

    round_trip()


@pytest.mark.parametrize("name", SERVICES)
def test_requests_and_responses_survive_it_as_well(name):
    service = load(name, "srv", "no such service")
    for cls in (service.Request, service.Response):
        again = cls()
        fill(again, parse(to_yaml(cls())))
        assert same(to_plain(again), to_plain(cls()))


@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        ("std_msgs/msg/String", "nope: 1", "'String' object has no attribute 'nope'"),
        ("std_msgs/msg/String", "data: [1]", "'data' takes a string, got a list of 1"),
        ("std_msgs/msg/String", "data:", "'data' takes a string, got nothing"),
        ("std_msgs/msg/Bool", "data: 1", "'data' takes true or false, got 1 (number)"),
        ("std_msgs/msg/Int8", "data: 128", "'data' takes a whole number from -128 to 127, got 128"),
        ("std_msgs/msg/UInt8", "data: -1", "'data' takes a whole number from 0 to 255, got -1"),
        ("std_msgs/msg/Int32", "data: true", "got True (boolean)"),
        ("std_msgs/msg/Int32", "data: 1.5", "got 1.5 (number)"),
        ("std_msgs/msg/Float32", "data: fast", "'data' takes a number, got 'fast' (string)"),
        ("std_msgs/msg/Byte", "data: 256", "'data' takes one byte"),
        ("std_msgs/msg/Int32MultiArray", "data: 5", "'data' takes a list, got 5 (number)"),
        ("std_msgs/msg/Int32MultiArray", "data: [1, x]", "'data[1]' takes a whole number"),
        (
            "sensor_msgs/msg/Imu",
            "orientation_covariance: [1.0]",
            "'orientation_covariance' takes a list of 9 values, got a list of 1",
        ),
        (
            "geometry_msgs/msg/PoseStamped",
            "pose: {position: {x: left}}",
            "'pose.position.x' takes a number, got 'left' (string)",
        ),
        ("geometry_msgs/msg/PoseStamped", "pose: 5", "'pose' takes the fields of Pose, got 5"),
        (
            "shape_msgs/msg/SolidPrimitive",
            "dimensions: [1.0, 2.0, 3.0, 4.0]",
            "'dimensions' takes a list of at most 3 values",
        ),
        (
            "std_msgs/msg/String",
            "data: 'open",
            "not YAML: found unexpected end",
        ),
        ("std_msgs/msg/String", "- 1", "needs to be a dictionary in YAML format"),
    ],
)
def test_a_value_that_does_not_fit_is_named(name, text, complaint):
    with pytest.raises(VerbError) as caught:
        fill(load_message(name)(), parse(text))
    assert complaint in caught.value.message


def test_the_message_of_service_events_is_found():
    event = load_message("std_srvs/srv/SetBool_Event")()
    fill(event, parse("{info: {event_type: 2}, response: [{success: true}]}"))
    assert (event.info.event_type, event.response[0].success) == (2, True)
    assert full_type("std_srvs/srv/SetBool_Event") == "std_srvs/srv/SetBool_Event"


@pytest.mark.parametrize(
    ("name", "kind", "hint"),
    [
        ("std_srvs/srv/SetBool", "msg", "std_srvs/srv/SetBool is made of: SetBool_Event, SetBool_"),
        ("std_srvs/srv/SetBool_Evnt", "msg", "std_srvs/srv/SetBool is made of: SetBool_Event, "),
        ("std_srvs/srv/SetBol", "msg", "did you mean SetBool?"),
        ("std_srvs/srv/SetBool_Event", "srv", "did you mean SetBool?"),
        ("std_srvs/srv/SetBool", "action", "std_srvs/srv/SetBool is a service, not an action"),
        ("std_msgs/msg/String", "srv", "std_msgs/msg/String is a message, not a service"),
        ("nope/msg/String", "srv", "no such type is installed"),
    ],
)
def test_a_type_of_another_kind_is_refused_with_what_there_is(name, kind, hint):
    with pytest.raises(VerbError, match="wrong") as caught:
        load(name, kind, "wrong")
    assert caught.value.hint.startswith(hint)


def test_an_unknown_field_has_a_near_miss():
    with pytest.raises(VerbError) as caught:
        fill(load_message("std_msgs/msg/String")(), {"dta": "x"})
    assert caught.value.hint == "did you mean 'data'?"


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("std_msgs/msg/Strnig", "did you mean String? (std_msgs/msg/String)"),
        ("std_msgs/Strnig", "did you mean String? (std_msgs/msg/String)"),
        ("std_msg/msg/String", "did you mean std_msgs/msg/String?"),
        ("nonsense", "no such type is installed: nonsense"),
        ("../msg/String", None),
    ],
)
def test_an_unknown_type_is_an_error_with_a_near_miss(name, hint):
    with pytest.raises(VerbError) as caught:
        load_message(name)
    assert caught.value.message == "The passed message type is invalid"
    assert hint in (None, caught.value.hint)


def test_scalars_become_strings_where_the_field_is_one():
    message = load_message("std_msgs/String")()
    fill(message, parse("data: 5"))
    assert message.data == "5"


def test_times_that_are_now_are_set_when_the_message_is_sent():
    message = load_message("geometry_msgs/msg/PointStamped")()
    stamps = fill(message, parse("header: auto"))
    now = load_message("builtin_interfaces/msg/Time")(sec=7, nanosec=8)
    for stamp in stamps:
        stamp(now)
    assert message.header.stamp == now


SHAPES = load_message("sensor_msgs/msg/JointState")(
    name=["left", "right"], position=[1.0, 2.0, 3.0]
)
IMU = load_message("sensor_msgs/msg/Imu")()


def test_long_things_are_cut_after_the_length():
    assert "position:\n- 1.0\n- 2.0\n- '...'" in to_yaml(SHAPES, Style(length=2))
    assert "- le...\n- ri..." in to_yaml(SHAPES, Style(length=2))
    assert to_csv(SHAPES, Style(length=1)) == "0,0,,l...,...,1.0,...,,"


def test_arrays_and_strings_can_be_left_out():
    text = to_yaml(SHAPES, Style(no_arr=True, no_str=True))
    assert "position: '<sequence type: double, length: 3>'" in text
    assert "frame_id: '<string length: <0>>'" in text
    assert "orientation_covariance: '<array type: double[9]>'" in to_yaml(IMU, Style(no_arr=True))


def test_flow_style_has_lists_on_one_line_and_blocks_around_them():
    text = to_yaml(SHAPES, Style(flow=True))
    assert text.startswith("header:\n  stamp:\n    sec: 0\n")
    assert "\nname: [left, right]\n" in text
    point = load_message("geometry_msgs/msg/Point32")
    polygon = load_message("geometry_msgs/msg/Polygon")(points=[point(x=1.0), point()])
    assert to_yaml(polygon, Style(flow=True)) == (
        "points: [{x: 1.0, y: 0.0, z: 0.0}, {x: 0.0, y: 0.0, z: 0.0}]\n"
    )


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("Empty", "types with such a name: std_msgs/msg/Empty, std_srvs/srv/Empty"),
        ("nav_msgs/Odom", "types with such a name: nav_msgs/msg/Odometry"),
        ("Xyzzy", "interface list lists the installed types"),
    ],
)
def test_an_unknown_interface_has_a_hint(name: str, hint: str):
    with pytest.raises(VerbError) as refused:
        resolve(name)
    assert hint in str(refused.value.hint)
