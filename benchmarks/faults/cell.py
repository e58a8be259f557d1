"""One run of the fault matrix: `python -m benchmarks.faults.cell SPEC`, in separate namespaces.

SPEC is JSON (`Spec`); the last line of the output is JSON, too (`Outcome`). Every process in the
namespace that is not of this program counts as left behind.
"""

from __future__ import annotations

import fcntl
import json
import os
import pty
import random
import signal
import subprocess
import sys
import tempfile
import termios
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

import psutil

from benchmarks.faults import hostile
from benchmarks.faults.namespace import command_line, description, is_alive, isolate
from launcher.control.client import Connection
from launcher.posix.socket_directory import ControlError

LAUNCHER, WATCHDOG, PREPARING, NODE = "launcher", "watchdog", "preparing process", "node"
WATCHER, PAGE, RECORDER, CONSOLE = "file watcher", "page", "flight recorder", "console"
# A word of the command line of each helper, and the option that starts it.
HELPERS = {
    WATCHDOG: ("watchdog.py", None),
    PREPARING: ("preparing.py", "--warm"),
    WATCHER: ("launcher.run.watch", "--watch"),
    PAGE: ("launcher.web.web_server", "--web"),
    RECORDER: ("launcher.bag.ros.flight", "--record"),
    CONSOLE: ("launcher.control.console", None),
}
PHASES = ("start", "run", "restart", "stop")
READY_S = 60.0
GONE_S = 15.0  # for the watchdog, or a launcher that was asked to stop
MOST_DELAY_S = {"start": 0.15, "run": 0.0, "restart": 0.06, "stop": 0.03}
NODES = 2  # so that there is a preparing process
TRACING = "lttng-ust-wait"  # made by the libraries of ROS, for the whole machine

FILE = """from launch import LaunchDescription
from launch.actions import ExecuteProcess
from launch_ros.actions import Node

def generate_launch_description():
    return LaunchDescription([
        ExecuteProcess(cmd={command!r}, name="hostile", output="screen",
                       sigterm_timeout="1", sigkill_timeout="1"),
        *(Node(executable={node!r}, name=f"node_{{number}}", output="screen")
          for number in range({nodes})),
    ])
"""
NEXT = """from launch import LaunchDescription
from launch.actions import ExecuteProcess

def generate_launch_description():
    return LaunchDescription([ExecuteProcess(cmd=["true"])])
"""
NODE_SCRIPT = """#!{python}
import os, rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("talker")
publisher = node.create_publisher(String, "talk", 10)
node.create_timer(0.1, lambda: publisher.publish(String(data="x")))
open(f"{folder}/{{os.getpid()}}", "x").close()
try:
    rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    pass
"""


@dataclass(frozen=True)
class Spec:
    """`victims` are killed in `phase`; the node has a `child`; `group` is for LAUNCHER_CGROUP."""

    victims: tuple[str, ...]
    phase: str
    child: str
    group: str
    seed: int


@dataclass
class Outcome:
    """What was left, as texts; all empty is as it should be. `seconds`: how long it took."""

    survivors: list[str] = field(default_factory=list)
    hangs: list[str] = field(default_factory=list)
    exit_codes: list[str] = field(default_factory=list)
    sockets: list[str] = field(default_factory=list)
    segments: list[str] = field(default_factory=list)
    next_start: list[str] = field(default_factory=list)
    seconds: float = 0.0

    @property
    def is_clean(self) -> bool:
        return not any(value for name, value in asdict(self).items() if name != "seconds")


class Cell:
    """`processes` are those that exist besides this program and its parents."""

    def __init__(self, spec: Spec, folder: Path) -> None:
        self.spec = spec
        self.outcome = Outcome()
        self._folder = folder
        self._notes = folder / "notes"
        self._random = random.Random(spec.seed)
        self._ours = {os.getpid(), *(one.pid for one in psutil.Process().parents())}
        self._launcher: subprocess.Popen[bytes] | None = None
        self._terminal = -1
        self._env = _environment(folder, spec.group)

    # ---- the steps

    def run(self) -> Outcome:
        began_s = time.monotonic()
        self._prepare()
        self._start()
        if self.spec.phase != "start":
            self._wait(self._is_ready, "the run is ready", READY_S)
        self._strike()
        self._end()
        self._look()
        self.outcome.seconds = time.monotonic() - began_s
        return self.outcome

    def _prepare(self) -> None:
        for name in ("notes", "log", "tmp", "home", "runtime"):
            (self._folder / name).mkdir(mode=0o700)
        script = os.path.abspath(hostile.__file__)
        command = [sys.executable, "-S", script, self.spec.child, str(self._notes)]
        node = self._folder / "node.py"
        node.write_text(NODE_SCRIPT.format(python=sys.executable, folder=self._notes))
        node.chmod(0o755)
        text = FILE.format(command=command, node=str(node), nodes=NODES)
        (self._folder / "faults.launch.py").write_text(text)
        (self._folder / "next.launch.py").write_text(NEXT)

    def _start(self) -> None:
        options = [HELPERS[one][1] for one in self.spec.victims if one in HELPERS]
        words = ["faults.launch.py", *(option for option in options if option)]
        output: int = subprocess.DEVNULL
        if CONSOLE in self.spec.victims:
            self._terminal, output = pty.openpty()
        self._launcher = subprocess.Popen(
            [sys.executable, "-m", "launcher", *words],
            cwd=self._folder,
            env=self._env,
            stdin=output,
            stdout=output,
            stderr=subprocess.STDOUT if self._terminal >= 0 else subprocess.PIPE,
            start_new_session=True,
            preexec_fn=_take_terminal if self._terminal >= 0 else None,
        )
        if self._terminal >= 0:
            os.close(output)
            os.set_blocking(self._terminal, False)

    def _is_ready(self) -> bool:
        """The parent, its child and the nodes have noted their pids; all victims are there."""
        noted = len(os.listdir(self._notes))
        return noted == 2 + NODES and all(self._pid(one) for one in self.spec.victims)

    def _strike(self) -> None:
        phase = self.spec.phase
        if phase == "restart":
            with self._connection() as connection:
                connection.send("restart", ["hostile"])
                time.sleep(self._random.uniform(0.0, MOST_DELAY_S[phase]))
                self._kill()
            return
        if phase == "stop":
            self._signal_launcher(signal.SIGINT)
        time.sleep(self._random.uniform(0.0, MOST_DELAY_S[phase]))
        if phase == "start":
            self._wait(lambda: all(map(self._pid, self.spec.victims)), "the victims", READY_S)
        self._kill()

    def _kill(self) -> None:
        pids = [self._pid(one) for one in self.spec.victims]
        for pid in pids:
            if pid:  # in a stop it may have ended
                os.kill(pid, signal.SIGKILL)

    def _end(self) -> None:
        """Wait for the end of a run whose launcher was killed, or end it."""
        if LAUNCHER in self.spec.victims:
            assert self._launcher is not None
            self._launcher.wait()
            if WATCHDOG in self.spec.victims:
                self._command("doctor", "--fix")
            self._wait(lambda: not self._processes(), "", GONE_S)
            return
        if self.spec.phase != "stop":
            self._recover()
            self._signal_launcher(signal.SIGINT)
        self._wait_for_launcher()

    def _recover(self) -> None:
        """The run answers, and its processes are there: a victim has been noticed."""
        self._wait(self._answers, "the run answers", READY_S)
        if NODE not in self.spec.victims and self.spec.phase == "restart":
            self._wait(lambda: len(os.listdir(self._notes)) >= 4 + NODES, "the restart", READY_S)

    def _answers(self) -> bool:
        try:
            with self._connection() as connection:
                connection.ask("ps", timeout_s=5.0)
        except ControlError:
            return False
        return True

    def _wait_for_launcher(self) -> None:
        launcher = self._launcher
        assert launcher is not None
        if not self._wait(lambda: launcher.poll() is not None, "the launcher ends", 2 * GONE_S):
            launcher.kill()
            launcher.wait()
            return
        # A process died, or had to be killed.
        expected = 130 if self._has_died() or "ignored" in self.spec.child else 0
        if launcher.returncode != expected:
            text = f"exit code {launcher.returncode} instead of {expected}"
            self.outcome.exit_codes.append(text)

    def _look(self) -> None:
        """What is left, and whether another run can be started."""
        self._drain()
        self.outcome.survivors += self._processes()
        done = self._command("next.launch.py")
        if done.returncode != 0:
            self.outcome.next_start.append(done.stderr.decode(errors="replace")[-500:])
        self._command("runs")  # which removes the socket of a killed run
        if LAUNCHER in self.spec.victims:
            self._command("doctor", "--fix")
        sockets = self._folder.joinpath("runtime").rglob("*.*")
        self.outcome.sockets += [path.name for path in sockets]
        found = os.listdir("/dev/shm")
        self.outcome.segments += [one for one in found if not one.startswith(TRACING)]

    # ---- what is there

    def _processes(self) -> list[str]:
        """Command lines of what is alive: any thread that is not a zombie."""
        launcher = self._launcher
        assert launcher is not None
        if launcher.poll() is None:
            return [] if LAUNCHER in self.spec.victims else ["the launcher"]
        return [
            description(pid) for pid in psutil.pids() if pid not in self._ours and is_alive(pid)
        ]

    def _pid(self, victim: str) -> int:
        assert self._launcher is not None
        if victim == LAUNCHER:
            return self._launcher.pid
        if victim == NODE:
            last = [self.spec.child, str(self._notes)]
            return next((pid for pid in psutil.pids() if command_line(pid)[-2:] == last), 0)
        word = HELPERS[victim][0]
        for pid in psutil.pids():
            is_it = any(word in (one, os.path.basename(one)) for one in command_line(pid))
            if pid not in self._ours and is_it:
                return pid
        return 0

    def _has_died(self) -> bool:
        """Whether the node was hit: in a stop it may have ended before."""
        paths = self._folder.joinpath("log").glob("[0-9]*/events.jsonl")
        events = [json.loads(line) for path in paths for line in path.open()]
        ends = [one for one in events if one["event"] == "ended" and not one["asked"]]
        killed = [one for one in events if one["event"] == "ended" and one["returncode"] == -9]
        return NODE in self.spec.victims and bool(ends or killed)

    def _connection(self) -> Connection:
        assert self._launcher is not None
        pattern = f"{self._launcher.pid}-*.sock"
        paths: list[Path] = []

        def find() -> bool:
            paths[:] = self._folder.joinpath("runtime").rglob(pattern)
            return bool(paths)

        self._wait(find, "the socket", READY_S)
        return Connection(paths[0], timeout_s=READY_S)

    def _signal_launcher(self, signum: int) -> None:
        assert self._launcher is not None
        if self._launcher.poll() is None:
            self._launcher.send_signal(signum)

    def _command(self, *words: str) -> subprocess.CompletedProcess[bytes]:
        command = [sys.executable, "-m", "launcher", *words]
        try:
            return subprocess.run(
                command,
                cwd=self._folder,
                env=self._env,
                capture_output=True,
                timeout=READY_S,
                check=False,
            )
        except subprocess.TimeoutExpired:
            self.outcome.hangs.append(f"`launcher {' '.join(words)}` does not end")
            return subprocess.CompletedProcess(command, -1, b"", b"does not end")

    def _wait(self, fact: Callable[[], object], what: str, timeout_s: float) -> bool:
        """Whether it holds in time; if not, it counts as a hang, unless it has no name."""
        until_s = time.monotonic() + timeout_s
        while not fact():
            self._drain()
            if time.monotonic() > until_s:
                if what:
                    there = [description(pid) for pid in psutil.pids() if pid not in self._ours]
                    text = f"not in {timeout_s:g} s: {what}; there are {there}"
                    self.outcome.hangs.append(text)
                return False
            time.sleep(0.01)
        return True

    def _drain(self) -> None:
        """Read the terminal: a full one would suspend the console."""
        try:
            while self._terminal >= 0 and os.read(self._terminal, 65536):
                pass
        except OSError:
            pass


def _take_terminal() -> None:
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)


def _environment(folder: Path, group: str) -> dict[str, str]:
    env = {name: value for name, value in os.environ.items() if not name.startswith("LAUNCHER_")}
    return {
        **env,
        "HOME": str(folder / "home"),
        "TMPDIR": str(folder / "tmp"),
        "XDG_RUNTIME_DIR": str(folder / "runtime"),
        "ROS_LOG_DIR": str(folder / "log"),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "LAUNCHER_CGROUP": group,
        "TERM": "xterm-256color",
    }


def main(text: str) -> None:
    fields: Mapping[str, object] = json.loads(text)
    spec = Spec(**{**fields, "victims": tuple(fields["victims"])})  # type: ignore[arg-type]
    isolate()
    with tempfile.TemporaryDirectory(prefix="faults-") as folder:
        outcome = Cell(spec, Path(folder)).run()
    print(json.dumps(asdict(outcome)))


if __name__ == "__main__":
    main(sys.argv[1])
