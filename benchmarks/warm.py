"""Warm starts against cold ones: real nodes, on a separate domain.

A benchmark of the group `warm` is a function of `runs` here or in another module, and a name
that begins with `warm-` in `benchmarks.__main__`.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import psutil

from benchmarks.contestant import REPOSITORY, end, python_environment, wait_for_end
from benchmarks.footprint import memory_mb
from benchmarks.harness import Row, interleaved, median, milliseconds, ratio, scratch
from launcher.control.client import Connection
from launcher.posix.domain_lease import leased_domain

COLD, WARM = "--cold", "--warm"
FLEET = ("dispatcher", "monitor", "robot_1", "robot_2", "robot_3", "debug_logger")
MANY = 20
RESTARTS = 8
TIMEOUT_S = 60.0
SETTLE_S = 1.0
IDLE_S = 3.0
PROFILE = REPOSITORY / "launcher/ros/probe/participant.xml"
OFTEN = {"status_period_s": 0.05}  # else a robot waits for a second with its first status

_FLEET_FILE = """from launch import LaunchDescription
from launch_ros.actions import Node

def generate_launch_description():
    return LaunchDescription([
        Node(package="group_gp1", executable=name, name=name, output="screen")
        for name in {names!r}
    ])
"""
_FILE = """from launch import LaunchDescription
from launch_ros.actions import Node

def generate_launch_description():
    return LaunchDescription([
        Node(executable={script!r}, name=f"node_{{number}}", output="screen",
             parameters={parameters!r})
        for number in range({count})
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
# robot_1, which prints when it has published its first status.
_ROBOT = """#!{python}
import time
from rclpy.publisher import Publisher
from group_gp1.robot_1 import main

publish, begun = Publisher.publish, []

def stamped(self, message):
    publish(self, message)
    if not begun and self.topic_name == "/fleet/status":
        begun.append(True)
        print("published", time.monotonic(), flush=True)

Publisher.publish = stamped
main()
"""
_OBSERVER = """
import contextlib, time, rclpy
rclpy.init()
node = rclpy.create_node("observer")
print("ready", flush=True)
seen = set()
with contextlib.suppress(KeyboardInterrupt):
    while True:
        for name in set(node.get_node_names()) - seen:
            print(name, time.monotonic(), flush=True)
            seen.add(name)
        time.sleep(0.02)
"""
_PLAIN_FILE = """from launch import LaunchDescription
from launch.actions import ExecuteProcess

def generate_launch_description():
    return LaunchDescription([ExecuteProcess(cmd=["sleep", "0.5"]) for _ in range(10)])
"""


class Run:
    """A running launcher; its output is in a file."""

    def __init__(self, process: subprocess.Popen[bytes], folder: Path, begun_s: float) -> None:
        self.process = process
        self.begun_s = begun_s
        self._folder = folder

    @property
    def screen(self) -> str:
        return (self._folder / "screen").read_text(errors="replace")

    def files(self, pattern: str) -> list[Path]:
        """Those of the run whose names are like this."""
        return list(self._folder.rglob(pattern))

    def ask(self, verb: str, *names: str) -> Mapping[str, object]:
        socket = next(iter(self._folder.rglob(f"{self.process.pid}-*.sock")))
        with Connection(socket, timeout_s=TIMEOUT_S) as connection:
            return connection.ask(verb, names, timeout_s=TIMEOUT_S).result


class Domain:
    """A separate ROS domain, and how the launcher is started in it."""

    def __init__(self, number: int) -> None:
        self.variables = {
            "ROS_DOMAIN_ID": str(number),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        }

    @contextlib.contextmanager
    def running(self, text: str, *words: str) -> Iterator[Run]:
        """Launch a file with this text."""
        with scratch() as folder, open(folder / "screen", "wb") as screen:
            file = folder / "bench.launch.py"
            file.write_text(text)
            env = {
                **python_environment(),
                **self.variables,
                "ROS_LOG_DIR": str(folder / "log"),
                "XDG_RUNTIME_DIR": str(folder),
            }
            begun = time.monotonic()
            process = subprocess.Popen(
                [sys.executable, "-m", "launcher", str(file), *words],
                cwd=REPOSITORY,
                env=env,
                stdin=subprocess.DEVNULL,
                stdout=screen,
                stderr=subprocess.STDOUT,
            )
            try:
                yield Run(process, folder, begun)
            finally:
                end(process)

    @contextlib.contextmanager
    def observed(self) -> Iterator[Observer]:
        """A node that sees the graph; it has discovered nobody yet.

        It announces itself five times a second, as the launcher's own observers do: Fast DDS's
        default of 3 s would be measured instead of the nodes (docs/reference/probe.md).
        """
        profile = {"FASTRTPS_DEFAULT_PROFILES_FILE": str(PROFILE)}
        program = subprocess.Popen(
            [sys.executable, "-c", _OBSERVER],
            env={**python_environment(), **self.variables, **profile},
            stdout=subprocess.PIPE,
        )
        try:
            observer = Observer(program)
            time.sleep(SETTLE_S)
            yield observer
        finally:
            program.send_signal(signal.SIGINT)
            program.wait()


class Observer:
    """Records when it has discovered which node."""

    def __init__(self, program: subprocess.Popen[bytes]) -> None:
        assert program.stdout is not None
        self._lines = program.stdout
        assert self._lines.readline() == b"ready\n"

    def wait_for(self, names: set[str]) -> float:
        """When it had discovered all of them."""
        moments: dict[str, float] = {}
        while names - moments.keys():
            name, _, moment = self._lines.readline().decode().partition(" ")
            moments[name] = float(moment)
        return max(moments[name] for name in names)


@contextlib.contextmanager
def _domain() -> Iterator[Domain]:
    with leased_domain() as number:
        yield Domain(number)


def _node_script(folder: Path, text: str) -> str:
    script = folder / "node"
    script.write_text(text.format(python=sys.executable))
    script.chmod(0o755)
    return str(script)


# ---- until all are there


def fleet(runs: int) -> list[Row]:
    """Six nodes of the fleet, all at once: from the command on, preparation included."""
    text = _FLEET_FILE.format(names=FLEET)
    measure = partial(_in_graph_s, text, set(FLEET))
    return [_row(f"the fleet: command to all {len(FLEET)} in the graph", 2.0, measure, runs)]


def twenty(runs: int) -> list[Row]:
    """The same with small nodes; from when they publish until all are known takes discovery."""
    with scratch() as folder:
        text = _FILE.format(script=_node_script(folder, _NODE), count=MANY, parameters=[])
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
        _domain() as domain,
        domain.observed() as observer,
        domain.running(text, how) as run,
    ):
        return observer.wait_for(names) - run.begun_s


def _published_s(text: str, how: str) -> float:
    with _domain() as domain, domain.running(text, how) as run:
        return max(_wait_for(run, "published", MANY)) - run.begun_s


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
    with _domain() as domain, scratch() as folder:
        script = _node_script(folder, _ROBOT)
        with domain.running(_FILE.format(script=script, count=1, parameters=[OFTEN]), how) as run:
            _wait_for(run, "published", 1)
            found = []
            for number in range(RESTARTS):
                time.sleep(SETTLE_S if not number else 0.5)
                asked = time.monotonic()
                run.ask("restart", "node-1")
                published = _wait_for(run, "published", number + 2)[-1]
                found.append(Restart(published - asked, published - _last_end(run)))
    return found


def _wait_for(run: Run, word: str, count: int) -> list[float]:
    """The times behind this word, when there are so many."""
    deadline = time.monotonic() + TIMEOUT_S
    while True:
        found = [float(text) for text in re.findall(rf"{word} ([\d.]+)\n", run.screen)]
        if len(found) >= count:
            return found
        if time.monotonic() > deadline:
            raise TimeoutError(run.screen)
        time.sleep(0.002)


def _last_end(run: Run) -> float:
    """When the last process ended, on the monotonic clock."""
    events = run.files("events.jsonl")[0].read_text().splitlines()
    ends = [one for one in map(json.loads, events) if one["event"] == "ended"]
    return float(ends[-1]["monotonic_s"])


# ---- memory, and what a run without nodes pays


def memory(runs: int) -> list[Row]:
    """PSS of the nodes; what is prepared is counted among them."""
    with _domain() as domain, scratch() as folder:
        text = _FILE.format(script=_node_script(folder, _NODE), count=MANY, parameters=[])
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
        _wait_for(run, "published", MANY)
        time.sleep(IDLE_S)
        children = psutil.Process(run.process.pid).children()
        nodes = [one.pid for one in children if "watchdog" not in " ".join(one.cmdline())]
        return sum(memory_mb(pid)[1] for pid in nodes) / MANY


def without_nodes(runs: int) -> list[Row]:
    """CPU time of a run that has no Python node, by default and with `--cold`."""
    with _domain() as domain:
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
