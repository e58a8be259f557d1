"""Bags of the whole fleet: played to a monitor, and read by the libraries of others."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from launcher.bag.bag_model import Message
from launcher.bag.reader import Bag
from tests.bag.ros.test_record import recording
from tests.support.bags import agreed_counts
from tests.support.repository import REPOSITORY
from tests.support.ros_domain import ros_domain
from tests.support.verbs import launcher
from tests.support.waiting import wait_until

REPORT, STATUS = "/fleet/report", "/fleet/status"
LAUNCHER = [sys.executable, "-m", "launcher"]


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


@contextlib.contextmanager
def running(env: Mapping[str, str], *words: str) -> Iterator[None]:
    """The launcher with these words, interrupted at the end."""
    process = subprocess.Popen(
        [*LAUNCHER, *words],
        env=dict(env),
        cwd=REPOSITORY,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield
    finally:
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=60) == 0


@pytest.mark.thorough
def test_a_monitor_counts_the_same_from_the_bag_of_a_killed_recorder(tmp_path: Path):
    bag, again = tmp_path / "bag", tmp_path / "again"
    with tempfile.TemporaryDirectory(prefix="run-") as short, ros_domain(tmp_path / "log") as env:
        env |= {"TMPDIR": short, "XDG_RUNTIME_DIR": short}
        with recording(env, bag, "-a") as recorder, running(env, "system", "--no-console"):
            wait_until(lambda: has_worked(bag), "reports of finished tasks")
            assert launcher(env, "stop", "dispatcher").code == 0
            stopped_ns = time.time_ns()
            wait_until(lambda: is_settled(bag, stopped_ns), "reports that stay the same")
            recorder.end(signal.SIGKILL)
        assert launcher(env, "bag", "check", "--repair", str(bag)).code == 0
        monitor = subprocess.Popen(
            [*LAUNCHER, "run", "group_gp1", "monitor"], env=env, stderr=subprocess.DEVNULL
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


def is_known(folder: Path) -> bool:
    """Whether the late publisher has been recorded for longer than from one look to the next."""
    late = [one.log_ns for one in messages(folder, STATUS) if text(one) == "late"]
    return bool(late) and late[-1] - late[0] > 2_500_000_000


@pytest.mark.thorough
def test_all_readers_see_all_messages_of_publishers_that_come_and_go(tmp_path: Path):
    whole, split, killed, memory = (tmp_path / name for name in ("whole", "split", "dead", "ring"))
    late = ("-r", "5", "--qos-reliability", "reliable", STATUS, "std_msgs/msg/String", "data: late")
    with (
        tempfile.TemporaryDirectory(prefix="run-") as short,
        ros_domain(tmp_path / "log") as env,
        recording(env, whole, "-a") as recorder,
        recording(env, split, "-a", "-d", "3") as splitter,
        recording(env, killed, "-a") as victim,
        recording(env, memory, "-a", "--snapshot-mode") as ring,
    ):
        env |= {"TMPDIR": short, "XDG_RUNTIME_DIR": short}
        with running(env, "system", "--no-console", "--record=all"):
            wait_until(lambda: has_worked(whole), "reports of finished tasks")
            ring.process.send_signal(signal.SIGUSR1)
            ring.read_until("wrote ")
            with running(env, "topic", "pub", *late):
                wait_until(lambda: is_known(whole) and is_known(split), "the late publisher")
                wait_until(lambda: is_known(killed), "the late publisher in the third bag")
                assert launcher(env, "restart", "robot_1").code == 0
                ring.process.send_signal(signal.SIGUSR1)
                ring.read_until("wrote ")
                assert launcher(env, "snapshot", "a late publisher").code == 0
                victim.end(signal.SIGKILL)
        assert [one.end() for one in (recorder, splitter, ring)] == [0, 0, 0]
        assert launcher(env, "bag", "check", "--repair", str(killed)).code == 0
        assert launcher(env, "bag", "convert", str(split), "-o", str(tmp_path / "copy")).code == 0
    flight = [*(tmp_path / "log").glob("*/bag"), *(tmp_path / "log").glob("*/snapshots/*/bag")]
    assert len(flight) >= 2
    for bag in (whole, split, killed, memory, tmp_path / "copy", *flight):
        counts = agreed_counts(bag)
        assert counts[STATUS] > 0, bag
