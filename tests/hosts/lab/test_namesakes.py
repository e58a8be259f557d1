"""Nodes with names of ours on other machines: reported, unless this run may have started them."""

from __future__ import annotations

import contextlib
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.children import children_with
from tests.support.hosts import Computer, Lab
from tests.support.hosts.checks import module
from tests.support.hosts.entered import Entered
from tests.support.hosts.operator import launcher_words
from tests.support.repository import REPOSITORY
from tests.support.waiting import wait_until

NODE = "tests.support.hosts.acquaintance"
ENV = {"ROS_DOMAIN_ID": "18"}  # the network is ours alone
WARNING = "already has nodes with names of this run"
LAUNCH = """
import sys
from launch import LaunchDescription
from launch_ros.actions import Node

def generate_launch_description():
    return LaunchDescription([
        Node(executable=sys.executable, arguments=["-m", "tests.support.hosts.acquaintance", "us"],
             name="talker", cwd={cwd!r}, prefix={prefix!r}),
        Node(executable=sys.executable, arguments=["-c", "import time; time.sleep(1000)"]),
    ])
"""


@contextlib.contextmanager
def running(computer: Computer, *words: str, screen: Path) -> Iterator[Entered]:
    with screen.open("wb") as out:
        options = {"env": ENV, "cwd": REPOSITORY, "stderr": subprocess.STDOUT}
        process = computer.popen(words, stdout=out, **options)
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(60)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "some.launch.py"


def launcher(lab: Lab, file: Path) -> contextlib.AbstractContextManager[Entered]:
    words = launcher_words([file, "--no-log-files"])
    return running(lab.operator, *words, screen=file.with_name("screen"))


def shown(file: Path) -> str:
    return file.with_name("screen").read_text(encoding="utf-8", errors="replace")


def test_a_node_of_another_machine_is_named_with_its_address(lab: Lab, file: Path):
    bot = lab.host("bot1")
    file.write_text(LAUNCH.format(cwd=str(REPOSITORY), prefix=None))
    with running(bot, *module(NODE, "talker"), screen=file.with_name("bot")):
        wait_until(lambda: "talker" in file.with_name("bot").read_text(), "it hears itself")
        with launcher(lab, file):
            wait_until(lambda: WARNING in shown(file), f"a warning; {shown(file)}")
    assert f"{WARNING}: /talker (at {bot.address}); " in shown(file)
    assert shown(file).count(WARNING) == 1


def test_a_node_that_this_run_starts_on_another_machine_is_ours(lab: Lab, file: Path):
    bot = lab.host("bot2")
    prefix = f"nsenter --target={bot.pid} -n --"  # in its network, as in a container
    file.write_text(LAUNCH.format(cwd=str(REPOSITORY), prefix=prefix))
    with running(bot, *module(NODE, "other"), screen=file.with_name("bot")):
        wait_until(lambda: "other" in file.with_name("bot").read_text(), "it hears itself")
        with launcher(lab, file) as run:
            wait_until(lambda: helpers(run), f"it looks; {shown(file)}")
            # As long as it can, since the second process might have the name of the other.
            wait_until(lambda: not helpers(run), "it has looked")
            nodes = lab.operator.launcher("node", "list", env=ENV).stdout
            assert nodes == "/other\n/talker\n"
    assert WARNING not in shown(file)


def helpers(run: Entered) -> list[int]:
    found = children_with(run.pid, "launcher.ros.helpers.namesakes")
    return [process.pid for process in found]
