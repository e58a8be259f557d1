"""Publishes numbered messages for tests of bags, on request.

On stdin, a line `N PERIOD_S` publishes the next N messages on each topic, when each has as many
subscriptions as it had before, and at least one; it answers `done`. Ends with stdin.
"""

from __future__ import annotations

import sys
import time

import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from rclpy.duration import Duration
from rclpy.qos import QoSProfile
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header, String, UInt8MultiArray

LATCHED = QoSProfile(depth=1000, durability=1)
BEST_EFFORT = QoSProfile(depth=1000, reliability=2)


def text(k: int) -> String:
    return String(data=f"text {k} \u00e4\u20ac" + "x" * (k % 50))


def pose(k: int) -> PoseStamped:
    message = PoseStamped(header=Header(stamp=Time(sec=k, nanosec=5), frame_id=f"frame {k}"))
    message.pose.position.x, message.pose.orientation.w = k * 0.25, 1.0
    return message


def cloud(k: int) -> PointCloud2:
    return PointCloud2(
        header=Header(frame_id="lidar"),
        height=1,
        width=k,
        fields=[PointField(name="x", datatype=7, count=1), PointField(name="yy", offset=4)],
        data=[n % 256 for n in range(k * 7)],
        is_dense=bool(k % 2),
    )


def big(k: int) -> UInt8MultiArray:
    return UInt8MultiArray(data=bytes([k % 256]) * 300_000)


# Topic -> the Kth message, its class, QoS.
TOPICS = {
    "/bag/text": (text, String, QoSProfile(depth=1000)),
    "/bag/pose": (pose, PoseStamped, LATCHED),
    "/bag/cloud": (cloud, PointCloud2, BEST_EFFORT),
    "/bag/big": (big, UInt8MultiArray, QoSProfile(depth=100)),
}


def main() -> None:
    rclpy.init(signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
    node = rclpy.create_node("bag_talker")
    names = sys.argv[1:] or list(TOPICS)
    publishers = {
        name: node.create_publisher(TOPICS[name][1], name, TOPICS[name][2]) for name in names
    }
    print("ready", flush=True)
    sent = 0
    for line in sys.stdin:
        count, period = line.split()
        while any(one.get_subscription_count() < 1 for one in publishers.values()):
            time.sleep(0.01)
        time.sleep(0.3)  # subscriptions discover a publisher after it has discovered them
        for k in range(sent, sent + int(count)):
            for name, publisher in publishers.items():
                publisher.publish(TOPICS[name][0](k))
            time.sleep(float(period))
        sent += int(count)
        for publisher in publishers.values():
            publisher.wait_for_all_acked(Duration(seconds=30))
        print("done", flush=True)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
