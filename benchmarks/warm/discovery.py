"""How soon nodes discover each other, with the launcher's introductions and without them."""

from __future__ import annotations

import json
import re
import time
from functools import partial

from benchmarks.contestant import REPOSITORY
from benchmarks.harness import Row, interleaved, median, milliseconds, scratch
from benchmarks.warm.domain import COLD, WARM, Run, nodes_file, private_domain

WAYS: dict[str, tuple[str, ...]] = {"with": (), "without": ("--no-introductions",)}
RESTARTS = 8
TASKS_S = 12.0  # until robot_3 works, too
# With introductions / without. Cold ones start one after the other, and hear the first
# announcements of those that follow.
LIMITS = {(6, COLD): 1.1, (6, WARM): 1.1, (20, COLD): 1.1, (20, WARM): 0.7}
ROBOT = "robot_1-3"
# Prints when it has discovered all; a node is in the graph when all others see it.
_NODE = """#!{python}
import contextlib, sys, time, rclpy
from rclpy.executors import ExternalShutdownException
rclpy.init()
node = rclpy.create_node("unnamed")
count = node.declare_parameter("count", 0).value
def look():
    if len(set(node.get_node_names())) >= count:
        print("complete", time.monotonic(), flush=True)
        timer.cancel()
timer = node.create_timer(0.05, look)
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(node)
node.destroy_node()
rclpy.try_shutdown()
"""


def graph(runs: int) -> list[Row]:
    """From the command on until each node has discovered each other one."""
    rows = []
    for (count, how), limit in LIMITS.items():
        measure = {name: partial(_complete_s, count, how, *words) for name, words in WAYS.items()}
        found = interleaved(max(2, runs // 2), measure)
        detail = f"with {milliseconds(found['with'])}, without {milliseconds(found['without'])}"
        what = f"{count} nodes, {how.strip('-')}: command to all know all, with introductions"
        value = median(found["with"]) / median(found["without"])
        rows.append(Row(f"{what} / without", value, "x", limit, detail))
    return rows


def _complete_s(count: int, *words: str) -> float:
    with private_domain() as domain, scratch() as folder:
        text = nodes_file(folder, _NODE, count, {"count": count})
        with domain.running(text, *words) as run:
            return max(run.times("complete", count)) - run.begun_s


def late(runs: int) -> list[Row]:
    """A robot of the fleet, restarted several times: from its start to its first assignment."""
    rows = []
    for how, limit_s in ((COLD, 0.5), (WARM, 0.3)):
        found = {name: _first_tasks(how, *words) for name, words in WAYS.items()}
        detail = f"{milliseconds(found['with'])}; without {milliseconds(found['without'])}"
        what = f"restart of a robot, {how.strip('-')}: started to its first assignment"
        rows.append(Row(what, median(found["with"]), " s", limit_s, detail))
    return rows


def _first_tasks(*words: str) -> list[float]:
    text = (REPOSITORY / "launch" / "system.launch.py").read_text()
    with private_domain() as domain, domain.running(text, *words) as run:
        time.sleep(TASKS_S)
        found = []
        for number in range(RESTARTS):
            run.ask("restart", ROBOT)
            started_s = _started(run, number + 2)
            found.append(_first_task(run, started_s) - started_s)
            time.sleep(1.3 + number / RESTARTS)  # other moments of the others' periods of 1 s
    return found


def _started(run: Run, count: int) -> float:
    """The wall time of so many starts of the robot, the first one included."""
    (events,) = run.files("events.jsonl")
    return run.wait_for(
        lambda: [
            float(one["wall_s"])
            for one in map(json.loads, events.read_text().splitlines())
            if one["event"] == "started" and one.get("process") == ROBOT
        ][count - 1 :]
    )[0]


def _first_task(run: Run, since_s: float) -> float:
    """The time of the first line about an assignment, by the clock of the node."""
    line = rf"^\[{ROBOT}\] \[INFO\] \[([\d.]+)\].*: (?:Backlog|Received)"
    return run.wait_for(
        lambda: [
            time_s
            for time_s in map(float, re.findall(line, run.screen, re.MULTILINE))
            if time_s > since_s
        ]
    )[0]
