"""Serialized messages of transforms."""

from __future__ import annotations

import pytest
from geometry_msgs.msg import Quaternion, TransformStamped, Vector3
from geometry_msgs.msg import Transform as TransformMessage
from rclpy.serialization import serialize_message

from launcher.ros.tf.tf_message import read
from tests.support.tf_messages import tf_message


def test_transforms_are_read_as_rclpy_writes_them():
    stamped = TransformStamped()
    stamped.header.stamp.sec, stamped.header.stamp.nanosec = -2, 5
    stamped.header.frame_id, stamped.child_frame_id = "map", "baß"
    stamped.transform = TransformMessage(
        translation=Vector3(x=1.0, y=2.0, z=3.0), rotation=Quaternion(x=0.1, y=0.2, z=0.3, w=0.4)
    )
    alone = serialize_message(stamped)

    message = tf_message(("map", "baß", -2 * 10**9 + 5, (1.0, 2.0, 3.0), (0.1, 0.2, 0.3, 0.4)))

    assert message[8:33] == alone[4:29]  # a list of one begins with its length
    assert message[-56:] == alone[-56:]
    [found] = read(message)
    assert (found.parent, found.child, found.stamp_ns) == ("map", "baß", -2 * 10**9 + 5)
    assert found.transform == ((1.0, 2.0, 3.0), (0.1, 0.2, 0.3, 0.4))


def test_slashes_in_front_of_frames_are_left_out():
    [found] = read(tf_message(("/map", "/base", 0, (0.0,) * 3, (0.0,) * 4)))

    assert (found.parent, found.child) == ("map", "base")


def test_several_transforms_of_any_alignment():
    names = [("map", "o"), ("odom", "ba"), ("base", "las"), ("b", "came")]
    message = tf_message(*((*pair, 7, (1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 1.0)) for pair in names))

    assert [(one.parent, one.child) for one in read(message)] == names
    assert {one.transform.translation for one in read(message)} == {(1.0, 2.0, 3.0)}


@pytest.mark.parametrize("length", [0, 3, 6, 17, 40])
def test_a_damaged_message_is_an_error(length):
    message = tf_message(("map", "base", 0, (0.0,) * 3, (0.0,) * 4))

    with pytest.raises(ValueError, match="a message is not a tf2_msgs/msg/TFMessage"):
        read(message[:length])
