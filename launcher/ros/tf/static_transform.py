"""`tf static`: a node that publishes one static transform, as static_transform_publisher does."""

from __future__ import annotations

import random
import string
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from launcher.base.program import program
from launcher.base.ros_errors import VerbError
from launcher.ros.messages.interfaces import load_message
from launcher.ros.tf.arithmetic import Transform, normalized, quaternion
from launcher.ros.tf.frame_buffer import StampedTransform, refusal
from launcher.ros.verb import warn

if TYPE_CHECKING:
    from rclpy.node import Node

POSITION, ANGLES, QUATERNION = ("x", "y", "z"), ("roll", "pitch", "yaw"), ("qx", "qy", "qz", "qw")
FRAMES = ("frame_id", "child_frame_id")
# Words without options: their count says which rotation they have.
_WORDS = {8: (*POSITION, *ANGLES[::-1], *FRAMES), 9: (*POSITION, *QUATERNION, *FRAMES)}
_LETTERS = string.digits + string.ascii_letters


def parsed(options: Mapping[str, str | None], words: Sequence[str]) -> StampedTransform:
    """The transform of the options, or of the words of old; VerbError."""
    given = {name: value for name, value in options.items() if value is not None}
    numbers = {
        name: _number(f"--{name.replace('_', '-')}", given[name]) for name in _numeric(given)
    }
    if numbers.keys() & {*ANGLES} and numbers.keys() & {*QUATERNION}:
        raise _fault("Cannot specify both quaternion and Euler rotations")
    if len(words) in _WORDS:
        warn("Old-style arguments are deprecated; see --help for new-style arguments")
        if given:
            raise _fault("Cannot specify both new-style (flags) and old-style (arguments)")
        given = dict(zip(_WORDS[len(words)], words, strict=True))
        numbers = {name: _number(name, given[name]) for name in _numeric(given)}
    elif words:
        raise _fault("Extra unparsed arguments on command-line")
    for name, title in zip(FRAMES, ("Frame id", "Child frame id"), strict=True):
        if not given.get(name):
            raise _fault(f"{title} must not be empty")
    return _checked(given["frame_id"], given["child_frame_id"], _transform(numbers))


def _numeric(given: Mapping[str, str]) -> list[str]:
    return [name for name in given if name not in FRAMES]


def _number(name: str, word: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise _fault(f"Failed to parse {name} argument as float") from None


def _transform(numbers: Mapping[str, float]) -> Transform:
    x, y, z = (numbers.get(name, 0.0) for name in POSITION)
    if numbers.keys() & {*ANGLES}:
        rotation = quaternion(*(numbers.get(name, 0.0) for name in ANGLES))
    else:
        qx, qy, qz = (numbers.get(name, 0.0) for name in QUATERNION[:3])
        rotation = (qx, qy, qz, numbers.get("qw", 1.0))
    return Transform((x, y, z), rotation)


def _checked(parent: str, child: str, transform: Transform) -> StampedTransform:
    if parent == child:
        raise VerbError(
            f"cannot publish static transform from '{parent}' to '{child}', exiting",
            hint="child_frame_id cannot equal frame_id",
        )
    try:
        rotation = normalized(transform.rotation)  # listeners from Kilted on take no other
    except ValueError as error:
        raise _fault(str(error)) from None
    stamped = StampedTransform(parent, child, 0, transform._replace(rotation=rotation))
    if (why := refusal(stamped)) is not None:
        warn(f"warning: listeners ignore this transform, {why}")
    return stamped


def _fault(text: str) -> VerbError:
    verb, frames = f"{program()} tf static", "FRAME CHILD"
    usage = f"""usage: {verb} [--x X] [--y Y] [--z Z] --frame-id FRAME --child-frame-id CHILD
         [--qx QX] [--qy QY] [--qz QZ] [--qw QW] | [--roll R] [--pitch P] [--yaw Y]
   or (deprecated): {verb} X Y Z YAW PITCH ROLL {frames}
   or (deprecated): {verb} X Y Z QX QY QZ QW {frames}"""
    return VerbError(f"error parsing command line arguments: {text}", hint=usage)


def node_name() -> str:
    return f"static_transform_publisher_{''.join(random.choices(_LETTERS, k=16))}"


def publish(node: Node, stamped: StampedTransform, message_class: Any) -> object:
    """Publish once, for all who come later; the publisher, which the caller keeps."""
    from rclpy.qos import DurabilityPolicy, QoSProfile

    _declare(node, stamped)
    profile = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = node.create_publisher(message_class, "/tf_static", profile)
    publisher.publish(message_class(transforms=[_message(node, stamped)]))
    (x, y, z), rotation = stamped.transform
    quoted = ", ".join(f"'{number:f}'" for number in rotation)
    node.get_logger().info(
        "Spinning until stopped - publishing transform\n"
        f"translation: ('{x:f}', '{y:f}', '{z:f}')\nrotation: ({quoted})\n"
        f"from '{stamped.parent}' to '{stamped.child}'"
    )
    return publisher


def _message(node: Node, stamped: StampedTransform) -> Any:
    message = load_message("geometry_msgs/msg/TransformStamped")(child_frame_id=stamped.child)
    message.header.stamp = node.get_clock().now().to_msg()
    message.header.frame_id = stamped.parent
    translation, rotation = message.transform.translation, message.transform.rotation
    translation.x, translation.y, translation.z = stamped.transform.translation
    rotation.x, rotation.y, rotation.z, rotation.w = stamped.transform.rotation
    return message


def _declare(node: Node, stamped: StampedTransform) -> None:
    """The node's parameters, which say what it publishes."""
    from rcl_interfaces.msg import ParameterDescriptor

    translation, rotation = stamped.transform
    values: dict[str, float | str] = {
        **{f"translation.{name}": value for name, value in zip("xyz", translation, strict=True)},
        **{f"rotation.{name}": value for name, value in zip("xyzw", rotation, strict=True)},
        "frame_id": stamped.parent,
        "child_frame_id": stamped.child,
    }
    for name, value in values.items():
        node.declare_parameter(name, value, ParameterDescriptor(read_only=True))
