"""A small system that is watched, and the stream of its faults."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from launcher.control.active_runs import ListedRun, wait_for_run
from launcher.posix.domain_lease import leased_domain
from launcher.posix.socket_directory import ControlError

NODES = str(Path(__file__).with_name("nodes.py"))
READY_S = 60.0
SETTLED_S = 16.0  # what has just been started is not judged yet
STOP_S = 30.0
SOURCES = ("source_a", "source_b")
_LAUNCH = f"""
import sys
from launch import LaunchDescription
from launch_ros.actions import Node


def source(letter):
    return Node(
        executable=sys.executable,
        arguments=[{NODES!r}, "source"],
        name="source_" + letter,
        parameters=[{{"topic": "/" + letter, "marker": "MARKER"}}],
        respawn=True,
        respawn_delay=1.0,
    )


def generate_launch_description():
    sink = Node(executable=sys.executable, arguments=[{NODES!r}, "sink"], name="sink")
    return LaunchDescription([source("a"), source("b"), sink])
"""
_EXPECT = """
expect:
  - {node: /source_a}
  - {node: /source_b}
  - {node: /sink}
  - {topic: /a, publishers: 1, subscriptions: 1}
  - {topic: /b, publishers: 1, subscriptions: 1}
  - {rate: /a, is: 10 Hz ± 20 %}
  - {rate: /b, is: 10 Hz ± 20 %}
  - {latency: /a, below: 80 ms}
  - {latency: /b, below: 80 ms}
  - {memory: 'source_*', growth: 30 MB/min}
  - {parameter: value, node: /source_a, is: 1.0}
  - {parameter: value, node: /source_b, is: 1.0}
  - {message: /a, fields: {point.x: {max: 5}}, all: true}
  - {message: /b, fields: {point.x: {max: 5}}, all: true}
  - {no_tracebacks: '*'}
"""


def _popen(words: list[str], env: dict[str, str], output: Any) -> subprocess.Popen[Any]:
    null = subprocess.DEVNULL
    return subprocess.Popen(words, stdin=null, stdout=output, stderr=output, env=env)


class Surroundings(NamedTuple):
    """Where a system runs: variables and further words of its launcher, and how that is started.

    `popen` has the words, the variables, and a file for the output.
    """

    environment: Mapping[str, str] = {}
    words: tuple[str, ...] = ()
    popen: Callable[[list[str], dict[str, str], Any], subprocess.Popen[Any]] | None = None


class WatchedSystem:
    """Started in a free ROS domain; use `with`. `changes` are (wall time, fault) in order."""

    def __init__(self, folder: Path, surroundings: Surroundings | None = None) -> None:
        self.folder = folder
        self.log_root = folder / "log"
        self.marker = folder / "marker"
        self.changes: list[tuple[float, dict[str, Any]]] = []
        self._surroundings = surroundings or Surroundings()
        self._stack = contextlib.ExitStack()

    def __enter__(self) -> WatchedSystem:
        self.log_root.mkdir(parents=True, exist_ok=True)
        file = self.folder / "watched.launch.py"
        file.write_text(_LAUNCH.replace("MARKER", str(self.marker)), encoding="utf-8")
        (self.folder / "watched.expect.yaml").write_text(_EXPECT, encoding="utf-8")
        domain = self._stack.enter_context(leased_domain())
        self.env = {
            **os.environ,
            "ROS_DOMAIN_ID": str(domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(self.log_root),
            **self._surroundings.environment,
        }
        words = [sys.executable, "-m", "launcher", str(file), "--watchful", "--no-console"]
        with (self.folder / "output.txt").open("wb") as output:
            popen = self._surroundings.popen or _popen
            self._launcher = popen([*words, *self._surroundings.words], self.env, output)
        self._stack.callback(self._stop)
        self.run: ListedRun = wait_for_run(self._launcher.pid, READY_S)
        threading.Thread(target=self._follow, daemon=True).start()
        self.await_settled()
        return self

    def __exit__(self, *error: object) -> None:
        self._stack.close()

    def _stop(self) -> None:
        self._launcher.send_signal(signal.SIGINT)
        try:
            self._launcher.wait(STOP_S)
        except subprocess.TimeoutExpired:
            self._launcher.kill()
            self._launcher.wait()

    def await_settled(self) -> None:
        """Until all processes have been running long enough to be judged."""
        deadline_s = time.monotonic() + READY_S
        while time.monotonic() < deadline_s:
            rows = self.rows()
            if len(rows) == 3 and all((r["uptime_s"] or 0) > SETTLED_S for r in rows):
                return
            time.sleep(0.2)
        raise TimeoutError("the system did not start")

    def _follow(self) -> None:
        with contextlib.suppress(ControlError), self.run.connect() as connection:
            for item in connection.follow("faults"):
                self.changes.append((time.time(), item))

    # ---- what it has

    def rows(self) -> list[dict[str, Any]]:
        with self.run.connect() as connection:
            found: list[dict[str, Any]] = connection.ask("ps").result["processes"]
            return found

    def pid(self, node: str) -> int:
        """Of the process of a node, when it runs."""
        deadline_s = time.monotonic() + READY_S
        while time.monotonic() < deadline_s:
            for row in self.rows():
                if f"/{node}" in row["node_names"] and row["pid"] is not None:
                    return int(row["pid"])
            time.sleep(0.1)
        raise TimeoutError(f"{node} does not run")

    def faults(self) -> list[dict[str, Any]]:
        with self.run.connect() as connection:
            found: list[dict[str, Any]] = connection.ask("faults").result["faults"]
            return found

    def confirmed(self, since_s: float) -> list[tuple[float, dict[str, Any]]]:
        """The faults that were confirmed since then, in order."""
        return [
            (at_s, fault)
            for at_s, fault in tuple(self.changes)
            if at_s >= since_s and fault["change"] == "confirmed"
        ]

    def await_health(self, within_s: float) -> bool:
        """Whether no fault is left, for two seconds."""
        deadline_s, well_s = time.monotonic() + within_s, time.monotonic()
        while time.monotonic() < deadline_s:
            if any(fault["state"] != "healed" for fault in self.faults()):
                well_s = time.monotonic()
            if time.monotonic() - well_s >= 2.0:
                return True
            time.sleep(0.2)
        return False

    # ---- what is done to it

    def set_parameter(self, node: str, name: str, value: object) -> None:
        words = ["param", "set", f"/{node}", name, json.dumps(value)]
        subprocess.run(
            [sys.executable, "-m", "launcher", *words],
            env=self.env,
            check=True,
            stdout=subprocess.DEVNULL,
        )

    @contextlib.contextmanager
    def program(self, *words: str) -> Iterator[subprocess.Popen[bytes]]:
        """Another program in the domain of the system, which is ended."""
        process = subprocess.Popen(
            words, env=self.env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        try:
            yield process
        finally:
            process.kill()
            process.wait()
