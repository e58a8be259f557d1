"""Long arrays are written without PyYAML, in the same format."""

from __future__ import annotations

import array
import sys
import tracemalloc

import pytest
from sensor_msgs.msg import CameraInfo, PointCloud2
from std_msgs.msg import Float32MultiArray, Float64MultiArray, Int8MultiArray, UInt8MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from launcher.ros.messages import to_yaml
from launcher.ros.messages.to_yaml import Style, dump, to_csv, to_plain, yaml_pieces

ODD = [0.0, -0.0, 0.1, 1e17, 1e-7, 1.5e300, -2.5e-9, float("nan"), float("inf"), float("-inf")]


def trajectory() -> JointTrajectory:
    points = [JointTrajectoryPoint(positions=[1.0, 2.5], velocities=ODD) for _ in range(2)]
    return JointTrajectory(joint_names=["a", "array-0-"], points=points)


MESSAGES = [
    UInt8MultiArray(data=bytes(range(256))),
    Int8MultiArray(data=[-128, 0, 127]),
    Float32MultiArray(data=ODD[:5]),
    Float64MultiArray(data=ODD),
    PointCloud2(data=b"\x00\xff\x0a"),
    CameraInfo(d=ODD),
    trajectory(),
]


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: type(message).__name__)
@pytest.mark.parametrize("length", [None, 2], ids=["whole", "cut"])
@pytest.mark.parametrize("flow", [False, True], ids=["block", "flow"])
def test_the_text_is_that_of_pyyaml(monkeypatch, message, length, flow):
    style = Style(length=length, flow=flow)
    monkeypatch.setattr(to_yaml, "LONG", sys.maxsize)
    expected = "".join(yaml_pieces(message, style))
    assert expected == dump(to_plain(message, style), flow=flow)
    monkeypatch.setattr(to_yaml, "LONG", 1)
    monkeypatch.setattr(to_yaml, "_PIECE", 3)
    assert "".join(yaml_pieces(message, style)) == expected


@pytest.mark.parametrize("message", MESSAGES[:4], ids=lambda message: type(message).__name__)
def test_the_values_between_commas_are_those_of_python(message):
    assert to_csv(message).endswith("0," + ",".join(str(value) for value in message.data))


def test_a_long_array_is_never_held_as_text():
    count = 2_000_000
    message = UInt8MultiArray(data=array.array("B", bytes(count)))
    tracemalloc.start()
    try:
        written = sum(len(piece) for piece in yaml_pieces(message, Style()))
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert written > count * len("\n- 0")
    assert peak < 3 * count  # a list of it would take 8 bytes a number, its text 4
