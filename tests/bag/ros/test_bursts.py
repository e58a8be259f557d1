"""More messages of a topic than a recorder takes in one turn."""

from __future__ import annotations

from pathlib import Path

from rclpy.duration import Duration
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from std_msgs.msg import String

from launcher.bag.ros.recorder import _BURST, Recorder, RecorderOptions
from launcher.bag.ros.sinks import Ring
from launcher.bag.topic_selection import Selection
from launcher.ros.discovery.observer import Observer
from tests.support.domain import private_domain
from tests.support.waiting import wait_until


def test_a_recorder_is_behind_until_all_are_taken(tmp_path: Path):
    options = RecorderOptions(selection=Selection(topics=("/often",)))
    profile = QoSProfile(depth=2 * _BURST)
    with private_domain(tmp_path) as domain, Observer(int(domain.env["ROS_DOMAIN_ID"])) as observer:
        recorder = Recorder(observer, options, Ring(1_000_000), lambda text: None)
        publisher = domain.listener.create_publisher(String, "/often", profile)
        wait_until(
            lambda: (recorder.poll(), publisher.get_subscription_count())[1], "a subscription"
        )
        send(publisher)
        taken = [(recorder.take(_BURST), recorder.is_behind) for _ in range(3)]
        send(publisher)
        taken += [(recorder.take(), recorder.is_behind)]  # before a pause, and at the end
        recorder.close()
    assert taken == [(_BURST, True), (1, False), (0, False), (_BURST + 1, False)]


def send(publisher: Publisher) -> None:
    """More than a recorder takes in one turn."""
    for number in range(_BURST + 1):
        publisher.publish(String(data=str(number)))
    assert publisher.wait_for_all_acked(Duration(seconds=20))
