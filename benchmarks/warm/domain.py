"""Runs of nodes in a private ROS domain, and an observer of its graph."""

from __future__ import annotations

import contextlib
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TypeVar

from benchmarks.contestant import REPOSITORY, end, python_environment
from benchmarks.harness import scratch
from launcher.control.client import Connection
from launcher.posix.domain_lease import leased_domain

T = TypeVar("T")

COLD, WARM = "--cold", "--warm"
TIMEOUT_S = 60.0
SETTLE_S = 1.0
PROFILE = REPOSITORY / "launcher/ros/probe/participant.xml"
OFTEN = {"status_period_s": 0.05}  # else a robot waits for a second with its first status

_FILE = """from launch import LaunchDescription
from launch_ros.actions import Node

def generate_launch_description():
    return LaunchDescription([
        Node(executable={script!r}, name=f"node_{{number}}", output="screen",
             parameters={parameters!r})
        for number in range({count})
    ])
"""
# robot_1, which prints when it has published its first status.
ROBOT = """#!{python}
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
# Prints when it has discovered which node.
OBSERVER = """
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

    def wait_for(
        self, look: Callable[[], T], *, pause_s: float = 0.02, timeout_s: float = TIMEOUT_S
    ) -> T:
        """The first result of `look` that is true; TimeoutError."""
        deadline = time.monotonic() + timeout_s
        while not (found := look()):
            if time.monotonic() > deadline:
                raise TimeoutError(self.screen[-2000:])
            time.sleep(pause_s)
        return found

    def times(self, word: str, count: int) -> list[float]:
        """The times behind this word on the screen, when there are so many."""

        def look() -> list[float]:
            found = [float(text) for text in re.findall(rf"{word} ([\d.]+)\n", self.screen)]
            return found if len(found) >= count else []

        return self.wait_for(look, pause_s=0.002)


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
            [sys.executable, "-c", OBSERVER],
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
def private_domain() -> Iterator[Domain]:
    """A domain that no other program uses."""
    with leased_domain() as number:
        yield Domain(number)


def nodes_file(
    folder: Path, program: str, count: int = 1, parameters: Mapping[str, object] | None = None
) -> str:
    """The text of a launch file for the nodes `node_0`, `node_1`, ..., which run this program.

    The program is written into the folder; its `{python}` is this interpreter.
    """
    script = folder / "node"
    script.write_text(program.format(python=sys.executable))
    script.chmod(0o755)
    return _FILE.format(
        script=str(script), count=count, parameters=[parameters] if parameters else []
    )
