"""The command line of `tf static`, with the errors of static_transform_publisher."""

from __future__ import annotations

import math

import pytest

from launcher.base.program import program
from launcher.base.ros_errors import VerbError
from launcher.ros.tf.arithmetic import quaternion
from launcher.ros.tf.static_transform import node_name, parsed

FRAMES = {"frame_id": "map", "child_frame_id": "odom"}


def test_without_numbers_it_is_the_identity():
    found = parsed(FRAMES, [])

    assert found == ("map", "odom", 0, ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))


def test_options():
    found = parsed({**FRAMES, "x": "1", "z": "-2.5", "yaw": "1.5", "roll": None}, [])

    assert found.transform.translation == (1.0, 0.0, -2.5)
    assert found.transform.rotation == pytest.approx(quaternion(0.0, 0.0, 1.5))
    turned = parsed({**FRAMES, "qz": "1", "qw": "0"}, [])
    assert turned.transform.rotation == (0.0, 0.0, 1.0, 0.0)


@pytest.mark.parametrize(
    ("words", "rotation"),
    [
        ("1 2 3 0.5 0 0 map odom", quaternion(0.0, 0.0, 0.5)),
        ("1 2 3 0 0.5 0.25 map odom", quaternion(0.25, 0.5, 0.0)),
        ("1 2 3 0.6 0 0 0.8 map odom", (0.6, 0.0, 0.0, 0.8)),
    ],
)
def test_words_of_old_are_accepted_with_a_warning(capsys, words, rotation):
    found = parsed({}, words.split())

    assert (found.parent, found.child) == ("map", "odom")
    assert found.transform.translation == (1.0, 2.0, 3.0)
    assert found.transform.rotation == pytest.approx(rotation)
    assert "Old-style arguments are deprecated" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "words", "text"),
    [
        ({}, "", "Frame id must not be empty"),
        ({"frame_id": "map"}, "", "Child frame id must not be empty"),
        ({**FRAMES, "frame_id": ""}, "", "Frame id must not be empty"),
        (
            {**FRAMES, "roll": "0", "qw": "1"},
            "",
            "Cannot specify both quaternion and Euler rotations",
        ),
        ({**FRAMES, "x": "one"}, "", "Failed to parse --x argument as float"),
        ({}, "1 2 3 0 0 zero map odom", "Failed to parse roll argument as float"),
        ({}, "1 2 3", "Extra unparsed arguments on command-line"),
        (
            {"x": "1"},
            "1 2 3 0 0 0 map odom",
            "Cannot specify both new-style (flags) and old-style (arguments)",
        ),
    ],
)
def test_errors(options, words, text):
    with pytest.raises(VerbError, match="error parsing command line arguments: ") as caught:
        parsed(options, words.split())

    assert caught.value.message.endswith(f": {text}")
    assert caught.value.exit_code == 1
    usage = str(caught.value.hint).splitlines()
    assert usage[0].startswith(f"usage: {program()} tf static [--x X] ")
    assert usage[2].endswith(" tf static X Y Z YAW PITCH ROLL FRAME CHILD")


@pytest.mark.parametrize("number", ["nan", "-nan"])
def test_what_listeners_ignore_is_published_with_a_warning(capsys, number):
    parsed({**FRAMES, "x": number}, [])

    assert capsys.readouterr().err == (
        "warning: listeners ignore this transform, TF_NAN_INPUT: it contains nan\n"
    )


def test_a_frame_below_itself_is_refused():
    with pytest.raises(VerbError, match="cannot publish static transform from 'a' to 'a', exiting"):
        parsed({"frame_id": "a", "child_frame_id": "a"}, [])


@pytest.mark.parametrize("qw", ["0", "nan", "inf"])
def test_what_is_no_rotation_is_refused(qw):
    with pytest.raises(VerbError, match="a quaternion of length"):
        parsed({**FRAMES, "qw": qw}, [])


def test_a_quaternion_is_normalized():
    found = parsed({**FRAMES, "qz": "3", "qw": "4"}, [])

    assert found.transform.rotation == pytest.approx((0.0, 0.0, 0.6, 0.8))


def test_each_publisher_has_a_name():
    assert node_name() != node_name()
    assert len(node_name()) == len("static_transform_publisher_") + 16
    assert math.isfinite(parsed({**FRAMES, "pitch": "3"}, []).transform.rotation[1])
