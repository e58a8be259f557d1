"""The fleet recorded, the recorder killed, its bag repaired, and played to a monitor."""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
import time
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


def messages(folder: Path, topic: str) -> list[Message]:
    if not folder.exists() or not list(folder.glob("*.mcap")):
        return []
    return list(Bag(str(folder)).messages([topic]))


def text(message: Message) -> str:
    return message.data[8:].rstrip(b"\0").decode()


def reports(folder: Path, since_ns: int = 0) -> list[str]:
    return [text(one) for one in messages(folder, REPORT) if one.log_ns >= since_ns]


def has_worked(folder: Path) -> bool:
    """Whether each of the three robots has completed a task."""
    return any(": 0" not in one and one.count(":") >= 3 for one in reports(folder))


def is_settled(folder: Path, since_ns: int) -> bool:
    """Whether the counts are final: a task takes 2 s at most, and so does the next report."""
    last = reports(folder, since_ns)[-3:]
    return len(last) == 3 and len(set(last)) == 1


@pytest.mark.thorough
def test_a_monitor_counts_the_same_from_the_bag_of_a_killed_recorder(tmp_path: Path):
    bag, again = tmp_path / "bag", tmp_path / "again"
    run = [sys.executable, "-m", "launcher"]
    with tempfile.TemporaryDirectory(prefix="run-") as short, ros_domain(tmp_path / "log") as env:
        env |= {"TMPDIR": short, "XDG_RUNTIME_DIR": short}
        with recording(env, bag, "-a") as recorder:
            fleet = subprocess.Popen(
                [*run, "system", "--no-console"], env=env, cwd=REPOSITORY, stdout=subprocess.DEVNULL
            )
            try:
                wait_until(lambda: has_worked(bag), "reports of finished tasks")
                assert launcher(env, "stop", "dispatcher").code == 0
                stopped_ns = time.time_ns()
                wait_until(lambda: is_settled(bag, stopped_ns), "reports that stay the same")
                recorder.end(signal.SIGKILL)
            finally:
                fleet.send_signal(signal.SIGINT)
                assert fleet.wait(timeout=60) == 0
        assert launcher(env, "bag", "check", "--repair", str(bag)).code == 0
        monitor = subprocess.Popen(
            [*run, "run", "group_gp1", "monitor"], env=env, stderr=subprocess.DEVNULL
        )
        try:
            with recording(env, again, REPORT) as recorder:
                assert launcher(env, "bag", "play", str(bag), "--topics", STATUS).code == 0
                told = len(reports(again))
                wait_until(lambda: len(reports(again)) >= told + 2, "another report")
                assert recorder.end() == 0
        finally:
            monitor.send_signal(signal.SIGINT)
            monitor.wait(timeout=60)
    assert reports(again)[-1] == reports(bag)[-1]
