"""The warning of more nodes than find each other, before they are started."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

MANY = """\
from launch import LaunchDescription
from launch.actions import TimerAction
from launch_ros.actions import Node


def node(number):
    return Node(executable="/bin/true", name=f"n{number}")


def generate_launch_description():
    later = [TimerAction(period=3600.0, actions=[node(n)]) for n in range(%d, 34)]
    return LaunchDescription([*map(node, range(%d)), *later])
"""


def run(folder, at_once: int, *words: str, **variables: str) -> str:
    path = folder / "many.launch.py"
    path.write_text(MANY % (at_once, at_once), encoding="utf-8")
    found = subprocess.run(
        [sys.executable, "-m", "launcher", *words[:1], str(path), *words[1:]],
        env={**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", **variables},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=60,
        check=False,
    )
    return found.stdout


@pytest.mark.parametrize("at_once", [34, 1])
def test_plan_warns_of_nodes_that_do_not_all_find_each_other(tmp_path, at_once):
    text = run(tmp_path, at_once, "plan", ROS_DOMAIN_ID="211")
    assert "warning: 34 nodes on domain 211 do not all find each other: " in text
    assert "; use --discovery server, or ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET" in text


@pytest.mark.parametrize("at_once", [34, 1])
def test_launch_warns_before_it_starts_them_also_of_those_of_timers(tmp_path, at_once):
    text = run(tmp_path, at_once, "launch", "--timeout", "0.1", ROS_DOMAIN_ID="211")
    warning = text.index("warning: 34 nodes on domain 211 do not all find each other: ")
    assert warning < text.index("process started with pid") and text.count("warning: 34") == 1


@pytest.mark.parametrize(
    ("words", "variables"),
    [
        (("plan",), {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}),
        (("plan", "--discovery", "server"), {}),
        (("plan", "--discovery", "multicast"), {}),
        (("plan",), {"ROS_DISCOVERY_SERVER": "127.0.0.1:11811"}),
    ],
)
def test_nothing_is_said_where_they_find_each_other(tmp_path, words, variables):
    assert "find each other" not in run(tmp_path, 34, *words, ROS_DOMAIN_ID="211", **variables)
