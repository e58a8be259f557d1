"""The fleet recorded, the recorder killed, its bag repaired, and played to a monitor."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from launcher.bag.model import Message
from launcher.bag.reader import Bag
from tests.ros.conftest import ros_domain
from tests.ros.test_bag_record import recording
from tests.support.node_process import REPOSITORY
from tests.support.verbs import launcher
from tests.support.waiting import wait_until

REPORT, STATUS = "/fleet/report", "/fleet/status"
APART_NS = 100_000_000  # a status so near to a report may be in it or not


def messages(folder: Path, topic: str) -> list[Message]:
    if not folder.exists() or not list(folder.glob("*.mcap")):
        return []
    return list(Bag(str(folder)).messages([topic]))


def text(message: Message) -> str:
    return message.data[8:].rstrip(b"\0").decode()


def settled_report(folder: Path) -> Message | None:
    """The last report that no status is near to."""
    statuses = [one.log_ns for one in messages(folder, STATUS)]
    for report in reversed(messages(folder, REPORT)):
        if all(abs(at - report.log_ns) > APART_NS for at in statuses):
            return report
    return None


def has_worked(folder: Path) -> bool:
    report = settled_report(folder)
    return report is not None and len(messages(folder, REPORT)) > 4 and "_1: 0" not in text(report)


@pytest.mark.thorough
def test_a_monitor_counts_the_same_from_the_bag_of_a_killed_recorder(tmp_path: Path):
    bag, cut, again = tmp_path / "bag", tmp_path / "cut", tmp_path / "again"
    with ros_domain(tmp_path / "log") as env:
        run = [sys.executable, "-m", "launcher"]
        fleet = subprocess.Popen(
            [*run, "system", "--no-console"], env=env, cwd=REPOSITORY, stdout=subprocess.DEVNULL
        )
        try:
            with recording(env, bag, "-a") as recorder:
                wait_until(lambda: has_worked(bag), "reports of finished tasks")
                recorder.end(signal.SIGKILL)
        finally:
            fleet.send_signal(signal.SIGINT)
            assert fleet.wait(timeout=60) == 0
        assert launcher(env, "bag", "check", "--repair", str(bag)).code == 0
        report = settled_report(bag)
        assert report is not None
        words = ("--topics", STATUS, "--end", f"{report.log_ns / 1e9:.6f}", "-o", str(cut))
        converted = launcher(env, "bag", "convert", str(bag), *words)
        assert converted.code == 0, converted
        monitor = subprocess.Popen(
            [*run, "run", "group_gp1", "monitor"], env=env, stderr=subprocess.DEVNULL
        )
        try:
            with recording(env, again, REPORT) as recorder:
                assert launcher(env, "bag", "play", str(cut)).code == 0
                told = len(messages(again, REPORT))
                wait_until(lambda: len(messages(again, REPORT)) >= told + 2, "another report")
                assert recorder.end() == 0
        finally:
            monitor.send_signal(signal.SIGINT)
            monitor.wait(timeout=60)
    assert text(messages(again, REPORT)[-1]) == text(report)
