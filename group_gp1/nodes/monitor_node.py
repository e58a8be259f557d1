"""The monitor: counts completed tasks and detects silent robots."""

from __future__ import annotations

import time

from group_gp1 import qos, settings, topics
from group_gp1.logic.bookkeeping import FleetBooks
from group_gp1.logic.messages import MessageError, report_text, RobotStatus
from group_gp1.logic.rejects import Rejects
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.node import Node
from std_msgs.msg import String

REPORT_PERIOD_S = 2.0  # 0.5 Hz
START_GRACE_S = 7.0  # robot_3 is started 5 s late, and needs a moment until its first status
SILENCE_CHECK_PERIOD_S = 0.1  # maximum delay of a warning
MAX_LISTED = 1000


class Monitor(Node):
    """Reads `/fleet/status`, publishes `/fleet/report`, warns about silent robots."""

    def __init__(self) -> None:
        super().__init__('monitor')
        self._books = self._open_books()
        self._listed_robots = settings.whole_number(
            self,
            'listed_robots',
            MAX_LISTED,
            low=0,
            high=MAX_LISTED,
            unit='robots',
            about='Robots that a report lists one by one; of more it has a summary',
        )
        self._rejects = Rejects(self.get_logger(), topics.STATUS)
        # Guards the dictionaries of counts and times: one status at a time, in order of arrival.
        # It does not exclude the two timers; the lock in FleetBooks does.
        status_group = MutuallyExclusiveCallbackGroup()
        # The report is independent of the subscription: it uses a copy of the counts and may
        # run while a status is recorded, so a flood of statuses cannot delay it.
        report_group = ReentrantCallbackGroup()
        # A group of its own: neither a slow status nor a slow report delays the check, and it
        # never overlaps itself, so no warning is given twice.
        silence_group = MutuallyExclusiveCallbackGroup()
        self._reports = self.create_publisher(String, topics.REPORT, qos.REPORT)
        self._statuses = self.create_subscription(
            String,
            topics.STATUS,
            self._enter_status,
            qos.status_profile(settings.status_queue_depth(self)),
            callback_group=status_group,
            qos_overriding_options=qos.DEPTH_PARAMETER,
        )
        self._report_timer = self.create_timer(
            REPORT_PERIOD_S, self._report, callback_group=report_group
        )
        self._silence_timer = self.create_timer(
            SILENCE_CHECK_PERIOD_S, self._check_silence, callback_group=silence_group
        )

    def _open_books(self) -> FleetBooks:
        robot_ids = settings.names(
            self,
            'robot_ids',
            ['robot_1', 'robot_2', 'robot_3'],
            about='Robots that are expected to report; others are counted once they do',
        )
        silence_timeout_s = settings.silence_timeout_s(self)
        start_grace_s = settings.number(
            self,
            'start_grace_s',
            START_GRACE_S,
            low=0.0,
            high=3600.0,
            unit='s',
            about='Time to start: the silence of a robot that never reported counts from its end',
        )
        return FleetBooks(
            robot_ids,
            silence_timeout_s=silence_timeout_s,
            start_grace_s=start_grace_s,
            now_s=time.monotonic(),
        )

    def _enter_status(self, message: String) -> None:
        try:
            status = RobotStatus.from_json(message.data)
        except MessageError as error:
            self._rejects.add(error)
            return
        arrival = self._books.record(status, now_s=time.monotonic())
        if arrival is not None:
            self.get_logger().info(str(arrival))

    def _report(self) -> None:
        counts = self._books.counts()
        if len(counts) <= self._listed_robots:
            text = report_text(counts)
        else:
            text = str(self._books.summary(now_s=time.monotonic()))
        self._reports.publish(String(data=text))
        self.get_logger().info(text)

    def _check_silence(self) -> None:
        for silence in self._books.new_silences(now_s=time.monotonic()):
            self.get_logger().warn(str(silence))
