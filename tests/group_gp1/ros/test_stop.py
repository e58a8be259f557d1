"""SIGINT and SIGTERM: every node ends by itself, quietly, with exit code 0."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from dataclasses import dataclass

import pytest

from group_gp1 import qos, topics
from group_gp1.logic.messages import TaskAssignment
from tests.support.repository import REPOSITORY

NODES = (
    "dispatcher",
    "monitor",
    "robot_1",
    "robot_2",
    "robot_3",
    "debug_logger",
    "qos_probe",
)
ROBOTS = ("robot_1", "robot_2", "robot_3")

# A node whose destruction loops in C with the GIL held, as that of Fast DDS may do.
HANGING = """
import time
from rclpy.node import Node
from group_gp1 import runner

class Hanging(Node):
    def destroy_node(self):
        {hang}

def make():
    print("ready", flush=True)
    return Hanging("hanging")

runner.{other_limit} = 600.0
runner.run(make)
"""
SIGNALS = (signal.SIGINT, signal.SIGTERM)
THOROUGH = pytest.mark.thorough


@dataclass(frozen=True, kw_only=True)
class End:
    """How a node ended."""

    code: int
    output: str


def end(node, signum) -> End:
    node.signal(signum)
    code = node.wait()
    return End(code=code, output=node.output)


@pytest.mark.parametrize(
    "signum",
    [signal.SIGINT, pytest.param(signal.SIGTERM, marks=THOROUGH)],
    ids=lambda one: one.name,
)
def test_idle_nodes_stop_quietly(domain, signum):
    nodes = [domain.start(name) for name in NODES]
    domain.wait_for_nodes(*NODES)
    ends = {node.name: end(node, signum) for node in nodes}

    assert {name: x.code for name, x in ends.items()} == dict.fromkeys(NODES, 0)
    assert [x.output for x in ends.values() if re.search("Traceback|Exception", x.output)] == []


@pytest.mark.parametrize(
    "signum",
    [pytest.param(signal.SIGINT, marks=THOROUGH), signal.SIGTERM],
    ids=lambda one: one.name,
)
def test_a_robot_stops_in_the_middle_of_its_task(domain, signum):
    robots = {name: domain.start(name, task_duration_s=3600.0) for name in ROBOTS}
    assign = domain.publisher(topics.TASKS, qos.TASKS)
    for robot_id in ROBOTS:
        assign(TaskAssignment(robot_id=robot_id, task="long_way").to_json())
    for robot in robots.values():
        domain.wait_for_line(robot, "executing...")
    ends = [end(robot, signum) for robot in robots.values()]

    assert [x.code for x in ends] == [0, 0, 0]
    assert [x.output for x in ends if "Traceback" in x.output or "complete" in x.output] == []


@pytest.mark.thorough
@pytest.mark.parametrize("signum", SIGNALS, ids=lambda signum: signum.name)
@pytest.mark.parametrize("name", ["dispatcher", "monitor", "robot_1", "qos_probe"])
def test_a_node_stops_quietly_while_it_starts(domain, name, signum):
    node = domain.start(name)
    # Python has no handler for SIGTERM of its own: from here on main is at work
    domain.wait_until(lambda: node.catches(signal.SIGTERM), "main has begun")

    ended = end(node, signum)
    assert ended.code == 0, ended.output
    assert not re.search("Traceback|Exception", ended.output), ended.output


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["dispatcher", "monitor", "robot_2"])
def test_a_second_signal_does_not_disturb_the_end(domain, name):
    node = domain.start(name)
    domain.wait_for_nodes(name)
    node.signal(signal.SIGINT)
    node.signal(signal.SIGTERM)
    node.signal(signal.SIGINT)

    assert node.wait() == 0
    assert "Traceback" not in node.output


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("hang", "other_limit", "signum"),
    [
        # On a busy machine the other limit may be reached before.
        ("sum(range(10**15))", "_CLEAN_UP_S", signal.SIGPROF),
        ("time.sleep(600)", "_CLEAN_UP_CPU_S", signal.SIGALRM),
    ],
    ids=["loops", "waits"],
)
def test_a_node_whose_destruction_hangs_dies(hang: str, other_limit: str, signum: int):
    code = HANGING.format(hang=hang, other_limit=other_limit)
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, stdout=subprocess.PIPE, cwd=REPOSITORY) as process:
        try:
            assert process.stdout is not None
            process.stdout.readline()
            process.send_signal(signal.SIGINT)
            assert process.wait(60) == -signum
        finally:
            process.kill()
