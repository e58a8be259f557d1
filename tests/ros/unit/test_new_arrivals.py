"""The times that the probe's request `arrivals` gives, and stamps in serialized messages."""

from __future__ import annotations

import struct

import pytest

from launcher.ros.probe.new_arrivals import (
    MOST,
    NANOS,
    NO_STAMP,
    NewArrivals,
    has_stamp,
    stamp_ns,
)


@pytest.mark.parametrize("order", ["<", ">"])
def test_a_stamp_is_read_in_both_byte_orders(order):
    encapsulation = b"\0\1\0\0" if order == "<" else b"\0\0\0\0"
    message = encapsulation + struct.pack(f"{order}iI", 12, 345) + b"rest"
    assert stamp_ns(message) == 12 * NANOS + 345
    assert stamp_ns(message[:11]) == NO_STAMP
    assert stamp_ns(encapsulation + bytes(8)) == NO_STAMP


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ({"header": "std_msgs/Header", "data": "double"}, True),
        ({"clock": "builtin_interfaces/Time"}, True),
        ({"data": "double", "header": "std_msgs/Header"}, False),
        ({"transforms": "sequence<geometry_msgs/TransformStamped>"}, False),
        ({}, False),
    ],
)
def test_only_a_time_that_comes_first_is_a_stamp(fields, expected):
    assert has_stamp(fields) is expected


def test_each_arrival_is_given_once_with_its_times():
    arrivals = NewArrivals()
    arrivals.add(NANOS, 5 * NANOS, 4 * NANOS)
    arrivals.add(2 * NANOS, 6 * NANOS)
    assert arrivals.document(stamped=True) == {
        "mono": [1.0, 2.0],
        "sent": [5.0, 6.0],
        "stamp": [4.0, None],
        "left_out": 0,
    }
    arrivals.add(3 * NANOS, 7 * NANOS)
    assert arrivals.document(stamped=False) == {
        "mono": [3.0],
        "sent": [7.0],
        "stamp": None,
        "left_out": 0,
    }


def test_only_the_newest_are_kept_and_the_others_counted():
    arrivals = NewArrivals()
    for number in range(3 * MOST):
        arrivals.add(number * NANOS, 0)
    found = arrivals.document(stamped=False)
    assert (len(found["mono"]), found["mono"][-1]) == (MOST, 3 * MOST - 1)
    assert found["left_out"] == 2 * MOST
    assert arrivals.document(stamped=False)["left_out"] == 0
