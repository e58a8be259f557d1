"""Transforms against matrices of numpy, and against values by hand."""

from __future__ import annotations

import math
from functools import reduce

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from launcher.ros.tf.arithmetic import (
    Transform,
    between,
    matrix,
    quaternion,
    roll_pitch_yaw,
    rotated,
)

ANGLES = st.floats(-math.pi, math.pi)
LENGTHS = st.floats(-1e3, 1e3)
TRANSFORMS = st.builds(
    lambda x, y, z, *angles: Transform((x, y, z), quaternion(*angles)),
    *[LENGTHS] * 3,
    *[ANGLES] * 3,
)
QUARTER = quaternion(0.0, 0.0, math.pi / 2)


def as_matrix(transform: Transform) -> np.ndarray:
    whole = np.eye(4)
    x, y, z, w = transform.rotation
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    whole[:3, :3] = np.eye(3) + 2 * w * cross + 2 * cross @ cross  # Rodrigues' formula
    whole[:3, 3] = transform.translation
    return whole


def about(axis: str, angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    rows = {
        "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }
    return np.array(rows[axis])


@given(st.lists(TRANSFORMS, min_size=1, max_size=6))
def test_a_chain_is_the_product_of_its_matrices(chain):
    whole = reduce(Transform.after, chain)

    expected = reduce(np.matmul, map(as_matrix, chain))
    np.testing.assert_allclose(as_matrix(whole), expected, atol=1e-8)


@given(TRANSFORMS)
def test_the_inverse_is_that_of_the_matrix(transform):
    expected = np.linalg.inv(as_matrix(transform))
    np.testing.assert_allclose(as_matrix(transform.inverse()), expected, atol=1e-8)


@given(ANGLES, ANGLES, ANGLES)
def test_roll_pitch_and_yaw_turn_about_fixed_axes(roll, pitch, yaw):
    expected = about("z", yaw) @ about("y", pitch) @ about("x", roll)

    rotation = quaternion(roll, pitch, yaw)

    np.testing.assert_allclose(matrix(rotation), expected, atol=1e-12)
    np.testing.assert_allclose(matrix(quaternion(*roll_pitch_yaw(rotation))), expected, atol=1e-6)


@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2])
def test_an_upright_frame_has_a_roll_and_no_yaw(pitch):
    half = math.sqrt(0.5)
    rotation = (0.0, math.copysign(half, pitch), 0.0, half)

    assert roll_pitch_yaw(rotation) == pytest.approx((0.0, pitch, 0.0))


def test_three_frames_by_hand():
    # base is 1 m in front of map and turned left; the arm is 2 m in front of it, and turned left
    base, arm = Transform((1.0, 0.0, 0.0), QUARTER), Transform((2.0, 0.0, 0.5), QUARTER)

    found = base.after(arm)

    assert found.translation == pytest.approx((1.0, 2.0, 0.5))
    assert roll_pitch_yaw(found.rotation) == pytest.approx((0.0, 0.0, math.pi))
    assert found.inverse().translation == pytest.approx((1.0, 2.0, -0.5))


def test_midway_is_half_of_the_distance_and_of_the_turn():
    one, other = Transform(), Transform((2.0, 4.0, -6.0), QUARTER)

    found = between(one, other, 0.5)

    assert found.translation == (1.0, 2.0, -3.0)
    assert roll_pitch_yaw(found.rotation) == pytest.approx((0.0, 0.0, math.pi / 4))


def test_the_shorter_arc_is_taken_whatever_the_sign_of_a_quaternion():
    x, y, z, w = QUARTER
    found = between(Transform(), Transform(rotation=(-x, -y, -z, -w)), 0.5)

    expected = quaternion(0.0, 0.0, math.pi / 4)
    np.testing.assert_allclose(matrix(found.rotation), matrix(expected), atol=1e-12)


@given(TRANSFORMS, TRANSFORMS, st.floats(0.0, 1.0))
def test_a_rotation_between_two_is_a_part_of_the_turn(one, other, ratio):
    found = between(one, other, ratio).rotation

    assert math.hypot(*found) == pytest.approx(1.0, abs=1e-6)
    assert turn(one.rotation, found) == pytest.approx(
        ratio * turn(one.rotation, other.rotation), abs=1e-5
    )


def turn(one: tuple, other: tuple) -> float:
    """The angle from one rotation to another."""
    difference = np.array(matrix(one)).T @ np.array(matrix(other))
    return math.acos(np.clip((np.trace(difference) - 1) / 2, -1, 1))


def test_equal_rotations_stay_as_they_are():
    assert between(Transform(rotation=QUARTER), Transform(rotation=QUARTER), 0.3).rotation == (
        pytest.approx(QUARTER)
    )
    assert rotated(QUARTER, (1.0, 0.0, 0.0)) == pytest.approx((0.0, 1.0, 0.0))
