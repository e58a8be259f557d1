"""Warm starts against cold ones: real nodes, on a separate domain."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import psutil

from benchmarks.contestant import wait_for_end
from benchmarks.footprint import memory_mb
from benchmarks.harness import Row, interleaved, median, milliseconds, ratio, scratch
from benchmarks.warm.domain import (
    COLD,
    OFTEN,
    ROBOT,
    SETTLE_S,
    WARM,
    Domain,
    Run,
    nodes_file,
    private_domain,
)

FLEET = ("dispatcher", "monitor", "robot_1", "robot_2", "robot_3", "debug_logger")
MANY = 20
RESTARTS = 8
IDLE_S = 3.0

_FLEET_FILE = """from launch import LaunchDescription
from launch_ros.actions import Node

def generate_launch_description():
    return LaunchDescription([
        Node(package="group_gp1", executable=name, name=name, output="screen")
        for name in {names!r}
    ])
"""
_NODE = """#!{python}
import contextlib, time, rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("unnamed")
publisher = node.create_publisher(String, "words", 10)
publisher.publish(String(data="word"))
print("published", time.monotonic(), flush=True)
node.create_timer(1.0, lambda: publisher.publish(String(data="word")))
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(node)
node.destroy_node()
rclpy.try_shutdown()
"""
_PLAIN_FILE = """from launch import LaunchDescription
from launch.actions import ExecuteProcess

def generate_launch_description():
    return LaunchDescription([ExecuteProcess(cmd=["sleep", "0.5"]) for _ in range(10)])
"""


# ---- until all are there


def fleet(runs: int) -> list[Row]:
    """Six nodes of the fleet, all at once: from the command on, preparation included."""
    text = _FLEET_FILE.format(names=FLEET)
    measure = partial(_in_graph_s, text, set(FLEET))
    return [_row(f"the fleet: command to all {len(FLEET)} in the graph", 2.0, measure, runs)]


def twenty(runs: int) -> list[Row]:
    """The same with small nodes; from when they publish until all are known takes discovery."""
    with scratch() as folder:
        text = nodes_file(folder, _NODE, MANY)
        names = {f"node_{number}" for number in range(MANY)}
        return [
            _row(f"{MANY} nodes: {what}", 4.0, measure, max(1, runs // 2))
            for what, measure in {
                "command to all have published": partial(_published_s, text),
                "command to all in the graph": partial(_in_graph_s, text, names),
            }.items()
        ]


def _row(what: str, limit: float, measure: Callable[[str], float], runs: int) -> Row:
    found = interleaved(runs, {how: partial(measure, how) for how in (COLD, WARM)})
    return _cold_against_warm(what, limit, found[COLD], found[WARM])


def _in_graph_s(text: str, names: set[str], how: str) -> float:
    with (
        private_domain() as domain,
        domain.observed() as observer,
        domain.running(text, how) as run,
    ):
        return observer.wait_for(names) - run.begun_s


def _published_s(text: str, how: str) -> float:
    with private_domain() as domain, domain.running(text, how) as run:
        return max(run.times("published", MANY)) - run.begun_s


def _cold_against_warm(what: str, limit: float, cold: list[float], warm: list[float]) -> Row:
    detail = f"cold {milliseconds(cold)}, warm {milliseconds(warm)}"
    value = median(cold) / median(warm)
    return Row(f"{what}, cold / warm", value, "x", limit, detail, at_least=True)


# ---- a restart


class Restart(NamedTuple):
    """Seconds from the request to the first status, and from the end of the old process to it."""

    whole_s: float
    start_s: float


def restart(runs: int) -> list[Row]:
    """One robot, restarted several times in a run.

    It needs 0.12 s to exit, warm or cold, and publishes its first status after 0.05 s.
    """
    found: dict[str, list[Restart]] = {COLD: [], WARM: []}
    for _ in range(max(1, runs // 3)):
        for how in (COLD, WARM):
            found[how] += _restarts(how)
    whats = (
        "request to its first status",
        "exit of the old process to its first status",
    )
    return [
        _cold_against_warm(
            f"restart of a robot: {what}",
            5.0,
            *([times[column] for times in found[how]] for how in (COLD, WARM)),
        )
        for column, what in enumerate(whats)
    ]


def _restarts(how: str) -> list[Restart]:
    with private_domain() as domain, scratch() as folder:
        text = nodes_file(folder, ROBOT, parameters=OFTEN)
        with domain.running(text, how) as run:
            run.times("published", 1)
            found = []
            for number in range(RESTARTS):
                time.sleep(SETTLE_S if not number else 0.5)
                asked = time.monotonic()
                run.ask("restart", "node-1")
                published = run.times("published", number + 2)[-1]
                found.append(Restart(published - asked, published - _last_end(run)))
    return found


def _last_end(run: Run) -> float:
    """When the last process ended, on the monotonic clock."""
    events = run.files("events.jsonl")[0].read_text().splitlines()
    ends = [one for one in map(json.loads, events) if one["event"] == "ended"]
    return float(ends[-1]["monotonic_s"])


# ---- memory, and what a run without nodes pays


def memory(runs: int) -> list[Row]:
    """PSS of the nodes; what is prepared is counted among them."""
    with private_domain() as domain, scratch() as folder:
        text = nodes_file(folder, _NODE, MANY)
        found = {how: _memory_mb(domain, text, how) for how in (COLD, WARM)}
    detail = f"{found[WARM]:.1f} MB of {found[COLD]:.1f}, {MANY} nodes and what has made them"
    return [
        Row(
            "PSS per node, warm against cold",
            found[WARM] / found[COLD],
            "x",
            0.5,
            detail,
        )
    ]


def _memory_mb(domain: Domain, text: str, how: str) -> float:
    with domain.running(text, how) as run:
        run.times("published", MANY)
        time.sleep(IDLE_S)
        children = psutil.Process(run.process.pid).children()
        nodes = [one.pid for one in children if "watchdog" not in " ".join(one.cmdline())]
        return sum(memory_mb(pid)[1] for pid in nodes) / MANY


def without_nodes(runs: int) -> list[Row]:
    """CPU time of a run that has no Python node, by default and with `--cold`."""
    with private_domain() as domain:
        found = interleaved(
            2 * runs,
            {name: partial(_cpu_s, domain, words) for name, words in _PLAIN.items()},
        )
    detail = f"default {milliseconds(found['default'])}, --cold {milliseconds(found[COLD])}"
    return [
        Row(
            "CPU of a run without nodes",
            ratio(found["default"], found[COLD]),
            "x",
            1.05,
            detail,
        )
    ]


_PLAIN: dict[str, Sequence[str]] = {"default": (), COLD: (COLD,)}


def _cpu_s(domain: Domain, words: Sequence[str]) -> float:
    before = os.times()
    with domain.running(_PLAIN_FILE, *words) as run:
        wait_for_end(run.process)
    after = os.times()
    return (
        after.children_user + after.children_system - before.children_user - before.children_system
    )
