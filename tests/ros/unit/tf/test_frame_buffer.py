"""Lookups in a buffer, with the errors of tf2's BufferCore."""

from __future__ import annotations

import math

import pytest

from launcher.ros.tf.arithmetic import Transform, quaternion, roll_pitch_yaw
from launcher.ros.tf.frame_buffer import StampedTransform, TfError, TransformBuffer

S = 1_000_000_000
LEFT = quaternion(0.0, 0.0, math.pi / 2)


def at(parent: str, child: str, time_s: float, x: float = 0.0, yaw: float = 0.0):
    transform = Transform((x, 0.0, 0.0), quaternion(0.0, 0.0, yaw))
    return StampedTransform(parent, child, round(time_s * S), transform)


def buffer_of(*moving: StampedTransform, static: tuple[StampedTransform, ...] = (), **more):
    buffer = TransformBuffer(**more)
    for one in static:
        assert buffer.add(one, is_static=True) is None
    for one in moving:
        assert buffer.add(one, is_static=False) is None
    return buffer


ROBOT = (at("map", "odom", 1.0, x=1.0), at("map", "odom", 3.0, x=3.0), at("odom", "base", 2.0, x=1))
LASER = at("base", "laser", 0.0, x=0.5, yaw=math.pi / 2)


def test_the_latest_is_at_the_last_time_that_all_moving_transforms_have():
    found = buffer_of(*ROBOT, static=(LASER,)).lookup("map", "laser")

    assert found.stamp_ns == 2 * S
    assert found.transform.translation == pytest.approx((2.0 + 1.0 + 0.5, 0.0, 0.0))
    assert roll_pitch_yaw(found.transform.rotation)[2] == pytest.approx(math.pi / 2)
    assert (found.parent, found.child) == ("map", "laser")


def test_the_other_direction_is_the_inverse():
    found = buffer_of(*ROBOT, static=(LASER,)).lookup("laser", "map")

    assert found.transform.translation == pytest.approx((0.0, 3.5, 0.0))
    assert roll_pitch_yaw(found.transform.rotation)[2] == pytest.approx(-math.pi / 2)


def test_two_branches_meet_in_their_common_frame():
    buffer = buffer_of(
        at("map", "base", 5.0, x=7.0),
        static=(at("base", "left", 0, x=1.0, yaw=math.pi / 2), at("base", "right", 0, x=-1.0)),
    )

    found = buffer.lookup("left", "right")

    assert found.stamp_ns == 0  # nothing on the way moves
    assert found.transform.translation == pytest.approx((0.0, 2.0, 0.0))
    assert buffer.chain("left", "right") == ("right", "base", "left")
    assert buffer.chain("map", "right") == ("right", "base", "map")
    assert buffer.chain("right", "map") == ("map", "base", "right")


def test_between_two_stamps_is_interpolated():
    turning = (at("map", "base", 1.0, x=0.0), at("map", "base", 2.0, x=4.0, yaw=math.pi / 2))

    found = buffer_of(*turning).lookup("map", "base", round(1.25 * S))

    assert found.stamp_ns == 1.25 * S
    assert found.transform.translation == pytest.approx((1.0, 0.0, 0.0))
    assert roll_pitch_yaw(found.transform.rotation)[2] == pytest.approx(math.pi / 8)


def test_stamps_in_any_order_and_twice():
    moving = [at("a", "b", time, x=time) for time in (3.0, 1.0, 2.0, 2.0)]

    found = buffer_of(*moving).lookup("a", "b", round(2.5 * S))

    assert found.transform.translation[0] == pytest.approx(2.5)


def test_between_two_parents_the_older_transform_holds():
    found = buffer_of(at("a", "c", 1.0, x=1.0), at("b", "c", 2.0, x=2.0)).lookup(
        "a", "c", 3 * S // 2
    )

    assert found.transform.translation[0] == 1.0


def test_a_frame_to_itself_need_not_exist():
    assert TransformBuffer().lookup("nowhere", "nowhere").transform == Transform()
    assert TransformBuffer().why_not("nowhere", "nowhere") is None
    assert buffer_of(at("a", "b", 4.0)).lookup("b", "b").stamp_ns == 4 * S


@pytest.mark.parametrize(
    ("target", "source", "time_s", "text"),
    [
        ("x", "map", 0, '"x" passed to lookupTransform argument target_frame does not exist. '),
        ("map", "x", 0, '"x" passed to lookupTransform argument source_frame does not exist. '),
        (
            "/map",
            "base",
            0,
            'Invalid argument "/map" passed to lookupTransform argument target_frame - '
            "in tf2 frame_ids cannot start with a '/'",
        ),
        (
            "map",
            "",
            0,
            'Invalid argument "" passed to lookupTransform argument source_frame - '
            "in tf2 frame_ids cannot be empty",
        ),
        (
            "map",
            "far",
            0,
            "Could not find a connection between 'map' and 'far' because they are not part of the "
            "same tree.Tf has two or more unconnected trees.",
        ),
        (
            "map",
            "odom",
            4,
            "Lookup would require extrapolation into the future.  Requested time 4.000000 but the "
            "latest data is at time 3.000000, when looking up transform from frame [odom] to frame "
            "[map]",
        ),
        (
            "odom",
            "map",
            0.5,
            "Lookup would require extrapolation into the past.  Requested time 0.500000 but the "
            "earliest data is at time 1.000000, when looking up transform from frame [map] to "
            "frame [odom]",
        ),
        (
            "map",
            "base",
            1.5,
            "Lookup would require extrapolation at time 1.500000, but only time 2.000000 is in the "
            "buffer, when looking up transform from frame [base] to frame [map]",
        ),
        (
            # both ways lack data: that with the newer data is the reason
            "base",
            "other",
            9,
            "Lookup would require extrapolation into the future.  Requested time 9.000000 but the "
            "latest data is at time 8.000000, when looking up transform from frame [other] to "
            "frame [base]",
        ),
    ],
)
def test_errors_have_the_texts_of_tf2(target, source, time_s, text):
    others = (at("map", "other", 1.0), at("map", "other", 8.0))
    buffer = buffer_of(*ROBOT, *others, static=(at("space", "far", 0),))

    with pytest.raises(TfError) as caught:
        buffer.lookup(target, source, round(time_s * S))

    assert str(caught.value) == text


def test_why_not_has_the_texts_of_can_transform():
    buffer = buffer_of(*ROBOT)

    assert buffer.why_not("map", "base") is None
    assert buffer.why_not("map", "base", 2 * S) is None
    assert buffer.why_not("map", "x") == (
        'Invalid frame ID "x" passed to canTransform argument source_frame - frame does not exist'
    )
    assert buffer.why_not("/map", "x") == (
        'Invalid frame ID "/map" passed to canTransform argument target_frame - '
        "in tf2 frame_ids cannot start with a '/'"
    )
    assert "extrapolation into the past" in str(buffer.why_not("map", "odom", S // 2))


def test_a_loop_is_named_with_all_frames():
    buffer = buffer_of(at("a", "b", 1.0), at("b", "c", 1.0), at("c", "a", 1.0), at("r", "s", 1.0))

    with pytest.raises(TfError) as caught:
        buffer.lookup("r", "a")

    assert str(caught.value) == (
        "The tf tree is invalid because it contains a loop.\n"
        "Frame b exists with parent a.\n"
        "Frame a exists with parent c.\n"
        "Frame c exists with parent b.\n"
        "Frame s exists with parent r.\n"
        "\n"
    )


def test_what_is_older_than_ten_seconds_is_forgotten():
    buffer = buffer_of(*(at("a", "b", time, x=time) for time in (1.0, 5.0, 12.0, 12.5)))

    assert "earliest data is at time 5.000000" in str(buffer.why_not("a", "b", 2 * S))
    assert str(buffer.add(at("a", "b", 2.0), is_static=False)).startswith("TF_OLD_DATA")
    assert buffer.why_not("a", "b", 6 * S) is None


def test_a_buffer_may_keep_everything():
    buffer = buffer_of(*(at("a", "b", time, x=time) for time in (1.0, 100.0)), keep_ns=None)

    assert buffer.lookup("a", "b", 34 * S).transform.translation[0] == pytest.approx(34.0)


def test_a_static_transform_becomes_a_moving_one_and_back():
    buffer = buffer_of(static=(at("a", "b", 9.0, x=1.0),))
    assert buffer.lookup("a", "b", 5).stamp_ns == 5

    buffer.add(at("a", "b", 3.0, x=2.0), is_static=False)
    assert buffer.lookup("a", "b").stamp_ns == 3 * S

    buffer.add(at("a", "b", 1.0, x=4.0), is_static=True)
    assert buffer.lookup("a", "b").transform.translation[0] == 4.0
    assert buffer.lookup("a", "b").stamp_ns == 0


@pytest.mark.parametrize(
    ("stamped", "name"),
    [
        (at("a", "a", 1.0), "TF_SELF_TRANSFORM"),
        (at("a", "", 1.0), "TF_NO_CHILD_FRAME_ID"),
        (at("", "b", 1.0), "TF_NO_FRAME_ID"),
        (at("a", "b", 1.0, x=math.nan), "TF_NAN_INPUT"),
        (
            at("a", "b", 1.0)._replace(transform=Transform(rotation=(0.0, 0.0, 0.0, 0.0))),
            "TF_DENORMALIZED_QUATERNION",
        ),
    ],
)
def test_what_listeners_ignore_is_ignored(stamped, name):
    buffer = TransformBuffer()

    assert str(buffer.add(stamped, is_static=False)).startswith(f"{name}: ")
    assert buffer.frames_text() == ""


def test_a_quaternion_of_another_length_is_normalized_as_in_jazzy():
    turned = Transform(rotation=(0.0, 0.0, 3.0, 4.0))
    buffer = buffer_of(StampedTransform("a", "b", S, turned))

    assert buffer.lookup("a", "b").transform.rotation == pytest.approx((0.0, 0.0, 0.6, 0.8))


def test_of_several_at_one_time_tf2_has_the_first_of_the_oldest_and_the_last_of_the_newest():
    buffer = buffer_of(*(at("a", "b", time, x=x) for x, time in enumerate((1.0, 1.0, 2.0, 2.0))))

    found = [buffer.lookup("a", "b", time * S).transform.translation[0] for time in (1, 2)]
    assert found == [0.0, 3.0]
