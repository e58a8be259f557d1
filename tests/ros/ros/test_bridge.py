"""`--ros`: diagnostics, control services, and the observer that serves the graph."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import shutil
import signal
import socket
import sys
import tempfile
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path

import psutil
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from std_srvs.srv import Trigger

from launcher.ros.discovery import graph_socket
from launcher.ros.discovery.discovery_reader import read_graph
from launcher.ros.discovery.observer import Observer
from launcher.ros.service_caller import ServiceCaller
from launcher.run.monitor.shared_memory import FOLDER, held
from tests.support.benches import HEAD
from tests.support.children import children_with, is_alive
from tests.support.controlled_run import ControlledRun
from tests.support.ros_domain import ros_domain, talking
from tests.support.waiting import wait_until
from tests.support.watcher_stand_in import IN_PLACE, Reports

OK, ERROR, STALE = DiagnosticStatus.OK, DiagnosticStatus.ERROR, DiagnosticStatus.STALE
SLEEPERS = """sh("exec sleep 1000", name="left"), sh("exec sleep 1000", name="right")"""


class Monitor:
    """What rqt would show: the last status of each name, and when messages came."""

    def __init__(self, observer: Observer) -> None:
        self.caller = ServiceCaller(observer)
        self.last: dict[str, DiagnosticStatus] = {}
        self.stamps_s: list[float] = []
        observer.node.create_subscription(DiagnosticArray, "/diagnostics", self._take, 50)

    def _take(self, message: DiagnosticArray) -> None:
        stamp = message.header.stamp
        self.stamps_s.append(stamp.sec + stamp.nanosec / 1e9)
        self.last.update({status.name: status for status in message.status})

    def wait(
        self, name: str, level: bytes, text: str, *, node: str = "launcher"
    ) -> DiagnosticStatus:
        """The status of a process when it is so."""

        def is_so() -> bool:
            self.caller.wait_until_done([_Never()], 0.05)
            one = self.last.get(f"{node}: {name}")
            return one is not None and one.level == level and text in one.message

        wait_until(is_so, f"{name}: {level!r} {text}; there is {self.last}")
        return self.last[f"{node}: {name}"]

    def launch(self, process: str, verb: str, node: str = "launcher") -> Trigger.Response:
        return self.caller.call(Trigger, f"/{node}/{process}/{verb}", Trigger.Request(), 60.0)


class _Never:
    def done(self) -> bool:
        return False


@pytest.fixture
def domain(tmp_path: Path) -> Iterator[dict[str, str]]:
    """A domain, and a folder for sockets, of our own."""
    with (
        # a bridge that is about to die may make its socket once more
        tempfile.TemporaryDirectory(prefix="run-", ignore_cleanup_errors=True) as runtime,
        ros_domain(tmp_path) as env,
    ):
        yield {**env, "TMPDIR": runtime, "XDG_RUNTIME_DIR": runtime}


def run_of(
    env: Mapping[str, str], folder: Path, actions: str = SLEEPERS, *words: str
) -> ControlledRun:
    file = folder / "bridge.launch.py"
    file.write_text(f"{HEAD}{actions}\n    ])\n", encoding="utf-8")
    return ControlledRun(
        [sys.executable, "-m", "launcher", str(file), "--ros", *words],
        env=env,
        runtime=Path(env["XDG_RUNTIME_DIR"]),
        screen=folder / "screen",
    )


@pytest.fixture
def run(domain: dict[str, str], tmp_path: Path) -> Iterator[ControlledRun]:
    """Two sleepers, shown to ROS."""
    with run_of(domain, tmp_path) as run:
        yield run


@pytest.fixture
def monitor(domain: dict[str, str]) -> Iterator[Monitor]:
    with Observer(int(domain["ROS_DOMAIN_ID"])) as observer:
        monitor = Monitor(observer)
        with monitor.caller:
            yield monitor


def bridge_pid(run: ControlledRun) -> int:
    """The bridge among the children of the launcher."""

    def find() -> list[psutil.Process]:
        return children_with(run.process.pid, "launcher.ros.helpers.bridge")

    wait_until(find, "a bridge is at work")
    return find()[0].pid


def answer_of_the_observer(env: Mapping[str, str], domain_id: int | None = None) -> str:
    """Its whole answer, however late; `domain_id` is another one than its own."""
    (path,) = Path(env["XDG_RUNTIME_DIR"]).rglob(f"*{graph_socket.SUFFIX}")
    question = json.dumps(graph_socket.query(domain_id or int(env["ROS_DOMAIN_ID"]), os.environ))
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as connection:
        connection.connect(str(path))
        connection.sendall(f"{question}\n".encode())
        return connection.makefile().readline()


def answers(env: Mapping[str, str], monkeypatch: pytest.MonkeyPatch) -> graph_socket.GraphSnapshot:
    """The answer of the run's observer once its graph is complete."""
    for name in ("XDG_RUNTIME_DIR", "TMPDIR", "ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE"):
        monkeypatch.setenv(name, env[name])
    domain_id = int(env["ROS_DOMAIN_ID"])
    try:
        wait_until(lambda: graph_socket.snapshot_of_run(domain_id), "the observer answers")
    except AssertionError as error:
        raise AssertionError(f"{error}; {answer_of_the_observer(env)}") from error
    looks: list[graph_socket.GraphSnapshot] = []

    def knows_nodes() -> bool:
        looks.extend(
            look for look in [graph_socket.snapshot_of_run(domain_id)] if look and look.nodes
        )
        return bool(looks)

    wait_until(knows_nodes, "it knows nodes")
    return looks[0]


def test_diagnostics_report_each_process_and_its_exit(run: ControlledRun, monitor: Monitor):
    left = monitor.wait("left-1", OK, "running")
    values = {value.key: value.value for value in left.values}
    assert values["pid"] == str(run.row("left")["pid"])
    assert {"state", "restarts", "uptime (s)"} <= values.keys()
    assert left.hardware_id == socket.gethostname()
    os.kill(run.row("left")["pid"], signal.SIGKILL)
    monitor.wait("left-1", ERROR, "exited unexpectedly: SIGKILL")
    monitor.wait("run", ERROR, "1 of 2 processes running; see left-1")


def test_diagnostics_report_faults_of_a_watched_run(
    domain: dict[str, str], tmp_path: Path, monitor: Monitor
):
    reports = Reports(tmp_path)
    reports.fault("confirmed")
    env = {**domain, **reports.env}
    with run_of(env, tmp_path, f"{IN_PLACE} {SLEEPERS}", "--watchful"):
        monitor.wait("fault robot_1 reports", ERROR, "no message for 3.0 s; cat-1 was killed")
        monitor.wait("run", ERROR, "2 of 2 processes running, 1 fault")
        reports.fault("healed", state="healed", healed_s=reports.now())
        monitor.wait("fault robot_1 reports", OK, "healed")
        monitor.wait("run", OK, "2 of 2 processes running")


@pytest.mark.thorough
def test_changes_are_published_before_the_next_period(run: ControlledRun, monitor: Monitor):
    monitor.wait("right-2", OK, "running")
    for _ in range(3):
        assert monitor.launch("right", "restart").success

    def is_told_early() -> bool:
        monitor.wait("right-2", OK, "running")
        stamps_s = monitor.stamps_s
        gaps_s = [b - a for a, b in itertools.pairwise(stamps_s)]
        return min(gaps_s, default=1.0) < 0.5  # the period is 1 s

    wait_until(is_told_early, "two messages in less than half a period")


def test_services_control_the_run_and_report_the_result(run: ControlledRun, monitor: Monitor):
    monitor.wait("left-1", OK, "running")
    stopped = monitor.launch("left", "stop")
    assert stopped.success
    assert stopped.message.startswith("left-1 stopped in ")
    monitor.wait("left-1", STALE, "stopped by request")
    assert run.row("left")["state"] == "STOPPED"
    assert monitor.launch("left", "start").message.startswith("left-1 started with pid ")
    again = monitor.launch("left", "start")
    assert not again.success
    assert "left-1" in again.message


def test_the_bridge_does_not_affect_the_end_of_the_run(domain, tmp_path, monitor: Monitor):
    actions = 'sh("read line; exit 3", name="brief")'
    with run_of(domain, tmp_path, actions) as run:
        monitor.wait("brief-1", OK, "running")
        pid = bridge_pid(run)
        run.ask_text("send", "brief", text="go")
        monitor.wait("brief-1", STALE, "the run has ended")
        assert run.exit_code() == 1
        assert not psutil.pid_exists(pid)
        assert not list(Path(domain["XDG_RUNTIME_DIR"]).rglob("*.graph"))
        assert "leftover processes" not in run.screen


@pytest.mark.thorough
def test_a_killed_launcher_takes_the_bridge_with_it(run: ControlledRun, monitor: Monitor):
    monitor.wait("left-1", OK, "running")
    pid = bridge_pid(run)
    run.process.kill()
    wait_until(lambda: not is_alive(pid), "the bridge has ended")


@pytest.mark.thorough
def test_a_bridge_that_dies_is_started_again_but_not_for_ever(run: ControlledRun, monitor: Monitor):
    monitor.wait("left-1", OK, "running")
    for count in range(1, 4):
        os.kill(bridge_pid(run), signal.SIGKILL)
        wait_until(
            lambda count=count: run.screen.count("the ROS bridge died (signal 9)") == count,
            "its death is told",
        )
    assert run.screen.count("restarting it") == 2
    assert "the run continues without it" in run.screen
    assert run.row("left")["state"] == "RUNNING"
    run.ask_text("quit")
    assert run.exit_code() == 0


@pytest.mark.thorough
def test_two_runs_in_one_domain_are_controlled_separately(
    run: ControlledRun, domain, tmp_path, monitor: Monitor
):
    monitor.wait("left-1", OK, "running")
    (tmp_path / "other").mkdir()
    with run_of(domain, tmp_path / "other") as other:
        node = f"launcher_{other.process.pid}"
        monitor.wait("left-1", OK, "running", node=node)
        assert monitor.launch("left", "stop", node).message.startswith("left-1 stopped in ")
        monitor.wait("left-1", STALE, "stopped by request", node=node)
        assert other.row("left")["state"] == "STOPPED"
        assert run.row("left")["state"] == "RUNNING"
        assert monitor.last["launcher: left-1"].level == OK


@pytest.mark.thorough
def test_a_deleted_socket_of_the_bridge_is_created_again(
    run: ControlledRun, domain: dict[str, str], monkeypatch: pytest.MonkeyPatch
):
    answers(domain, monkeypatch)
    folder = Path(domain["XDG_RUNTIME_DIR"]) / "ros-launcher"
    (path,) = folder.rglob(f"*{graph_socket.SUFFIX}")
    made_ns = path.stat().st_ctime_ns
    path.unlink()
    shutil.rmtree(folder, ignore_errors=True)
    wait_until(lambda: path.exists() and path.stat().st_ctime_ns != made_ns, "it is made again")
    assert answers(domain, monkeypatch).nodes == ("/launcher",)


@pytest.mark.alone  # what `doctor --fix` of another test frees, the launcher cannot
@pytest.mark.thorough
def test_what_a_killed_bridge_had_in_shared_memory_is_freed(
    run: ControlledRun, domain: dict[str, str], monkeypatch: pytest.MonkeyPatch
):
    # No other node: Fast DDS frees the segment of one that was killed as well, where it was read.
    answers(domain, monkeypatch)
    pid = bridge_pid(run)
    (segment, *_) = [name for name, owner in held().items() if owner == pid and "port" not in name]
    with run.connect() as connection:  # it is noted once a second, before the samples
        events = connection.follow("events", history=False)
        for _ in range(2):
            next(event for event in events if event["event"] == "resources")
    os.kill(pid, signal.SIGKILL)
    wait_until(lambda: not (Path(FOLDER) / segment).exists(), "its segment is gone")
    run.wait_for("of shared memory of killed nodes")


def test_ros_without_a_socket_is_a_usage_error(domain, tmp_path):
    with run_of(domain, tmp_path, SLEEPERS, "--no-control") as run:
        assert run.exit_code() == 2
        assert "--ros needs the control socket" in run.screen


@pytest.mark.thorough
def test_the_observer_of_a_run_has_the_same_graph_as_a_new_snapshot(
    run: ControlledRun, domain: dict[str, str], monkeypatch: pytest.MonkeyPatch
):
    domain_id = int(domain["ROS_DOMAIN_ID"])
    assert answers(domain, monkeypatch).nodes == ("/launcher",)
    with talking(domain, "tests.support.sample_nodes"):

        def has_seen_all_too() -> bool:
            ours = read_graph(domain_id, 10.0, remote=False).snapshot
            return "/talker" in ours.nodes and graph_socket.snapshot_of_run(domain_id) == ours

        wait_until(has_seen_all_too, "both have seen the same")

        def both_are_the_same() -> bool:
            words = ("topic", "list", "-v")
            quick, own = run.shell(*words), run.shell(*words, "--no-observer")
            # On a busy machine a look may end too early, but then it says so.
            assert quick.stdout == own.stdout or "may be missing" in quick.stderr + own.stderr
            return quick.stdout == own.stdout

        wait_until(both_are_the_same, "the same list both ways")


def test_the_observer_refuses_requests_for_another_domain_or_range(
    run: ControlledRun, domain: dict[str, str], monkeypatch: pytest.MonkeyPatch
):
    answers(domain, monkeypatch)
    domain_id = int(domain["ROS_DOMAIN_ID"])
    assert "another domain" in answer_of_the_observer(domain, domain_id + 1)
    assert graph_socket.snapshot_of_run(domain_id + 1) is None
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    assert "another domain" in answer_of_the_observer(domain)
    assert graph_socket.snapshot_of_run(domain_id) is None


def test_an_observer_that_does_not_answer_is_passed_over(domain, monkeypatch):
    folder = Path(domain["XDG_RUNTIME_DIR"]) / "ros-launcher"
    folder.mkdir(mode=0o700)
    monkeypatch.setenv("XDG_RUNTIME_DIR", domain["XDG_RUNTIME_DIR"])
    with socket.socket(socket.AF_UNIX) as deaf:
        deaf.bind(str(folder / "1-a.graph"))
        deaf.listen()
        assert graph_socket.snapshot_of_run(int(domain["ROS_DOMAIN_ID"])) is None
        assert (folder / "1-a.graph").exists()
    assert graph_socket.snapshot_of_run(int(domain["ROS_DOMAIN_ID"])) is None
    assert not (folder / "1-a.graph").exists()  # nobody is behind it any more


@pytest.mark.thorough
def test_malformed_requests_do_not_harm_the_observer(
    run: ControlledRun, domain: dict[str, str], monkeypatch: pytest.MonkeyPatch
):
    answers(domain, monkeypatch)
    path = next(Path(domain["XDG_RUNTIME_DIR"]).rglob("*.graph"))
    assert path.stat().st_mode & 0o777 == 0o600
    for noise in (b"\n", b"[]\n", b"{\n", b'{"domain_id": []}\n', b"x" * 100_000):
        with socket.socket(socket.AF_UNIX) as client:
            client.connect(str(path))
            sender = threading.Thread(target=_send, args=(client, noise))
            sender.start()
            sender.join()
    assert answers(domain, monkeypatch).nodes == ("/launcher",)


def _send(client: socket.socket, noise: bytes) -> None:
    try:
        client.sendall(noise)
    except OSError:
        return  # it has heard enough


@pytest.mark.thorough
def test_a_killed_node_is_a_ghost_for_earlier_participants(
    run: ControlledRun, domain: dict[str, str], monkeypatch: pytest.MonkeyPatch
):
    answers(domain, monkeypatch)
    # Each with a ghost of its own, since the middleware forgets them after 20 s. On a busy machine
    # an answer of the observer may be too late, and then they look themselves.
    with ghost(domain):
        wait_until(
            lambda: "/talker" in json.loads(run.shell("graph", "--json").stdout)["ghosts"],
            "a ghost in the graph",
        )
    with ghost(domain):
        assert "/talker" not in run.shell("node", "list", "--no-observer").stdout
    with ghost(domain):
        wait_until(lambda: "ghost" in liveness(run, "/talker"), "a ghost among the processes")


@contextlib.contextmanager
def ghost(domain: dict[str, str]) -> Iterator[None]:
    """A node that the observer of the run has seen alive, and killed."""
    domain_id = int(domain["ROS_DOMAIN_ID"])
    with talking(domain, "tests.support.sample_nodes") as program:
        wait_until(
            lambda: (look := graph_socket.snapshot_of_run(domain_id)) and "/talker" in look.nodes,
            "it is seen",
        )
        os.kill(program.pid, signal.SIGKILL)
        program.wait()
        wait_until(
            lambda: (look := graph_socket.snapshot_of_run(domain_id)) and "/talker" in look.ghosts,
            "a ghost",
        )
        yield


def liveness(run: ControlledRun, node: str) -> set[str]:
    rows = json.loads(run.shell("node", "ps", "--json").stdout)["nodes"]
    return {row["liveness"] for row in rows if row["name"] == node}
