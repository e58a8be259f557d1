"""What a page asks of the probe ends with the page, and a probe that dies is replaced."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path

import pytest

from tests.support.children import children_with
from tests.support.controlled_run import ControlledRun
from tests.support.waiting import wait_until
from tests.support.web_page import PageClient, server_of
from tests.web.process.conftest import Start

pytestmark = pytest.mark.thorough

TOPIC = "/told"
LISTENER = f"""
import rclpy
from rclpy.node import Node
from std_msgs.msg import Int32

rclpy.init()
node = Node("listener")
node.create_subscription(Int32, "{TOPIC}", lambda message: print("heard", flush=True), 100)
rclpy.spin(node)
"""


@pytest.fixture
def listening(tmp_path: Path) -> Path:
    """A launch file with a node that says `heard` for each message."""
    program, path = tmp_path / "listener.py", tmp_path / "listener.launch.py"
    program.write_text(LISTENER)
    path.write_text(
        "import sys\n"
        "from launch import LaunchDescription\n"
        "from launch.actions import ExecuteProcess\n\n\n"
        "def generate_launch_description():\n"
        f"    command = [sys.executable, {str(program)!r}]\n"
        "    node = ExecuteProcess(cmd=command, name='listener', output='screen')\n"
        "    return LaunchDescription([node])\n"
    )
    return path


def heard(page: PageClient) -> int:
    return sum(row[4] == "heard" for row in page.lines())


def publish(page: PageClient, number: int, **fields: object) -> None:
    """Begin to publish, without waiting for the answer."""
    words = {"do": "publish", "topic": TOPIC, "type": "std_msgs/msg/Int32", **fields}
    request = {"values": {"data": 1}, "rate_hz": 20, "timeout_s": 60, **words}
    page.socket.send(json.dumps({"id": number, "do": "probe", "request": request}))


def wait_for_beat(page: PageClient) -> None:
    """Wait until the server has told again that it is alive, as it does every 2 s."""
    before = len(page.of("alive"))
    wait_until(lambda: len(page.of("alive")) > before, "a beat")


def is_silent(page: PageClient) -> bool:
    """Whether nothing is heard from one beat to the next."""
    wait_for_beat(page)
    before = heard(page)
    wait_for_beat(page)
    return heard(page) == before


def test_publishing_ends_with_the_page(start: Start, listening: Path):
    _, link = start(listening)
    with PageClient(link) as watching:
        watching.open()
        with PageClient(link) as page:
            page.open()
            publish(page, 900, times=100_000)
            wait_until(lambda: heard(watching) > 5, "messages")
        wait_until(lambda: is_silent(watching), "the end of the messages", timeout_s=60)
        assert heard(watching) < 1000


def test_publishing_is_cancelled_and_limited(start: Start, listening: Path):
    _, link = start(listening)
    with PageClient(link) as page:
        page.open()
        assert page.ask("cancel", of=900)["result"] == {"cancelled": False}
        publish(page, 900, times=100_000)
        wait_until(lambda: heard(page) > 5, "messages")
        assert page.ask("cancel", of=900)["result"] == {"cancelled": True}
        wait_until(lambda: 900 in page.answers, "the answer")
        assert 5 < page.answers[900]["result"]["published"] < 1000
        many = {"do": "publish", "topic": TOPIC, "times": 100_001}
        refusal = page.ask("probe", request=many)["error"]
        assert (refusal["code"], "100,000" in refusal["message"]) == ("bad-request", True)


def probe_of(run: ControlledRun) -> int | None:
    """The process of the probe."""
    server = server_of(run.process.pid)
    found = [] if server is None else children_with(server, "launcher.ros.probe")
    return found[0].pid if found else None


def kill_probe(run: ControlledRun) -> int:
    wait_until(lambda: probe_of(run) is not None, "a probe")
    pid = probe_of(run)
    assert pid is not None
    os.kill(pid, signal.SIGKILL)
    return pid


def has_rates(page: PageClient, after: int) -> bool:
    """Whether a message after so many events has a rate of a topic that is measured."""
    said = [m for m in list(page.events)[after:] if m["event"] == "topics"]
    return any(one["state"] == "subscribed" for m in said for one in m["topics"].values())


def test_a_probe_that_dies_is_told_and_replaced(start: Start, listening: Path):
    run, link = start(listening)
    with PageClient(link) as page:
        assert page.open()["graph"] == {"available": True, "reason": None}
        page.ask("topics", on=True)
        wait_until(lambda: has_rates(page, 0), "rates")
        kill_probe(run)
        wait_until(lambda: page.of("probe"), "the death of the probe")
        assert page.of("probe")[0]["available"] is False
        assert "-9" in page.of("probe")[0]["reason"]
        wait_until(lambda: page.of("probe")[-1]["available"], "another probe")
        assert page.of("probe")[-1]["reason"] is None
        after = page.events.index(page.of("probe")[-1])
        wait_until(lambda: has_rates(page, after), "rates again")
        with PageClient(link) as other:
            assert other.open()["graph"] == {"available": True, "reason": None}


def test_a_probe_that_dies_again_and_again_is_left_alone(start: Start, sleeper: Path):
    run, link = start(sleeper)
    with PageClient(link) as page:
        page.open()
        for number in range(4):
            pid = kill_probe(run)  # maybe before it was ready: then the pages are told once
            if number < 3:
                wait_until(lambda pid=pid: probe_of(run) != pid, "its end")
        wait_until(lambda: "4 times" in str(page.of("probe")[-1:]), "the last death")
        assert "4 times" in page.of("probe")[-1]["reason"]
        wait_for_beat(page)
        wait_for_beat(page)
        assert probe_of(run) is None
        answer = page.ask("probe", request={"do": "explain", "topic": TOPIC})
        assert "4 times" in answer["error"]["message"]
