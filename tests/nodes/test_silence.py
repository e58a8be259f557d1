"""The monitor's warnings about silent robots, with the default timeout of 5 s."""

from __future__ import annotations

import pytest

from group_gp1 import qos, topics
from group_gp1.messages import RobotStatus, Status
from launcher.pytest_plugin import Launch

SILENT = "robot_1 has not reported in 5.0 s"
BACK = "robot_1 is reporting again after"


@pytest.mark.thorough
def test_a_killed_robot_is_missed_after_five_seconds_and_welcomed_back(launched_system: Launch):
    fleet = launched_system("system", probe=False)
    fleet.wait_for_log("monitor", "Fleet report -- robot_1: [1-9]")  # surely heard while it lives
    fleet.kill("robot_1")
    killed_s = fleet.facts.now_s
    warned = fleet.wait_for_log("monitor", SILENT)

    fleet.start("robot_1")
    back = fleet.wait_for_log("monitor", BACK)
    longer_s = back.at_s + 6.0  # than a silence that would be warned about
    fleet.wait_until(lambda: fleet.facts.now_s > longer_s, "time goes on")

    # its last status may be up to one period, 1 s, older than its death
    assert 4.0 - 0.1 <= warned.at_s - killed_s <= 8.0
    assert warned.level == "WARN"
    missed = [line for line in fleet.logs("monitor") if "robot_1 has not reported" in line]
    assert missed == [warned.plain]


def test_a_robot_that_never_reported_is_missed_five_seconds_after_the_start(domain):
    monitor = domain.start("monitor", robot_ids="[robot_7]")
    domain.wait_for_line(monitor, "robot_7 has not reported in 5.0 s")
    first_report_s = monitor.matching("Fleet report")[0].logged_s
    warned_s = monitor.matching("robot_7 has not reported")[0].logged_s

    # the first report comes 2 s after the start
    assert 2.5 <= warned_s - first_report_s <= 4.5


@pytest.mark.thorough
def test_a_flood_of_statuses_does_not_hold_the_silence_check_back(domain):
    monitor = domain.start("monitor", robot_ids="[robot_8]", silence_timeout_s=2.0)
    say = domain.publisher(topics.STATUS, qos.STATUS)
    status = RobotStatus(robot_id="robot_9", status=Status.DONE, task="t", task_id="x-1").to_json()

    def flooded() -> bool:
        for _ in range(20):
            say(status)
        return bool(monitor.matching("robot_8 has not reported in 2.0 s"))

    domain.wait_for_line(monitor, "Fleet report")
    domain.wait_until(flooded, "the warning comes during the flood", 20.0)
    domain.wait_for_line(monitor, "Fleet report -- robot_8: 0 tasks, robot_9: 1 tasks")
