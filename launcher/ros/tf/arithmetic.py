"""Rotations and translations, as tf2 computes them.

A rotation is a quaternion (x, y, z, w) of length 1. Tuples of floats: numpy takes longer for
three numbers.
"""

from __future__ import annotations

import math
from typing import NamedTuple

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


class Transform(NamedTuple):
    """Brings coordinates of a child frame into its parent: rotate, then add the translation."""

    translation: Vector = (0.0, 0.0, 0.0)
    rotation: Quaternion = (0.0, 0.0, 0.0, 1.0)

    def after(self, first: Transform) -> Transform:
        """The transform that does `first`, then this one."""
        x, y, z = rotated(self.rotation, first.translation)
        a, b, c = self.translation
        return Transform((x + a, y + b, z + c), product(self.rotation, first.rotation))

    def inverse(self) -> Transform:
        back = conjugate(self.rotation)
        x, y, z = rotated(back, self.translation)
        return Transform((-x, -y, -z), back)


_TOLERANCE = 0.01  # of the square of a quaternion's length


def is_unit(q: Quaternion) -> bool:
    """Whether tf2 takes its length for 1."""
    return abs(sum(number * number for number in q) - 1.0) < _TOLERANCE


def normalized(q: Quaternion) -> Quaternion:
    """The same rotation with length 1; ValueError for 0 and what is not finite."""
    length = math.hypot(*q)
    if not 0.0 < length < math.inf:
        raise ValueError(f"a quaternion of length {length:g} is no rotation")
    x, y, z, w = (number / length for number in q)
    return (x, y, z, w)


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """The rotation by `b`, then by `a`."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by + ay * bw + az * bx - ax * bz,
        aw * bz + az * bw + ax * by - ay * bx,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def conjugate(q: Quaternion) -> Quaternion:
    return (-q[0], -q[1], -q[2], q[3])


def rotated(q: Quaternion, v: Vector) -> Vector:
    return product(product(q, (*v, 0.0)), conjugate(q))[:3]


def between(one: Transform, other: Transform, ratio: float) -> Transform:
    """At a `ratio` of the way: straight for the translation, the shorter arc for the rotation."""
    a, b = one.translation, other.translation
    x, y, z = (p + (q - p) * ratio for p, q in zip(a, b, strict=True))
    return Transform((x, y, z), _slerp(one.rotation, other.rotation, ratio))


def _slerp(one: Quaternion, other: Quaternion, ratio: float) -> Quaternion:
    dot = math.fsum(p * q for p, q in zip(one, other, strict=True))
    size = math.hypot(*one) * math.hypot(*other)
    angle = math.acos(min(1.0, abs(dot) / size))
    if math.sin(angle) == 0.0:
        return one
    first = math.sin((1.0 - ratio) * angle) / math.sin(angle)
    second = math.copysign(math.sin(ratio * angle) / math.sin(angle), dot)
    x, y, z, w = (p * first + q * second for p, q in zip(one, other, strict=True))
    return (x, y, z, w)


def matrix(q: Quaternion) -> tuple[Vector, Vector, Vector]:
    """The rows of the rotation's matrix."""
    x, y, z, w = q
    s = 2.0 / (x * x + y * y + z * z + w * w)
    return (
        (1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)),
        (s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)),
        (s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)),
    )


def roll_pitch_yaw(q: Quaternion) -> Vector:
    """Angles in radians about the fixed axes x, y, z, in this order."""
    (xx, _, _), (yx, _, _), (zx, zy, zz) = matrix(q)
    if abs(zx) >= 1.0:  # upright: yaw and roll turn about the same axis
        return (math.atan2(zy, zz), math.copysign(math.pi / 2.0, -zx), 0.0)
    return (math.atan2(zy, zz), -math.asin(zx), math.atan2(yx, xx))


def quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
    about_x = (math.sin(roll / 2.0), 0.0, 0.0, math.cos(roll / 2.0))
    about_y = (0.0, math.sin(pitch / 2.0), 0.0, math.cos(pitch / 2.0))
    about_z = (0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0))
    return product(about_z, product(about_y, about_x))
