"""Starts that wait for facts of the ROS graph, told by real nodes."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from tests.support.benches import ControlBench, bench_with_sockets
from tests.support.controlled_run import ControlledRun
from tests.support.repository import REPOSITORY
from tests.support.ros_domain import ros_domain
from tests.support.waiting import wait_until

FACTS = {
    "node": ("{node: /late}", "no node /late"),
    "publisher": ("{publisher: /words}", "no publisher on /words"),
    "subscription": ("{subscription: /words}", "no subscription on /words"),
    "message": ("{message: /words}", "no message on /words"),
    "service": ("{service: /trigger}", "no service /trigger"),
    "lifecycle": ("{lifecycle: active}", "its lifecycle state is unconfigured"),
}


@pytest.fixture
def graph_bench(tmp_path: Path) -> Iterator[ControlBench]:
    """A bench whose runs have a domain of their own."""
    with ros_domain(tmp_path / "log") as env, bench_with_sockets(ControlBench, tmp_path) as bench:
        bench.env = {**bench.env, **env, "PYTHONPATH": str(REPOSITORY)}
        yield bench


def launch(bench: ControlBench, kind: str, rules: str, *words: str) -> ControlledRun:
    """A node that gets what a fact is about when the file `go` appears, and `worker`."""
    (bench.folder / "bench.supervise.yaml").write_text(rules, encoding="utf-8")
    node = (
        '__import__("launch_ros.actions").actions.Node(executable=sys.executable, name="late", '
        f'arguments=["-m", "tests.support.ready_node", "{kind}", "{bench.folder}/go"], '
        'output="screen", ros_arguments=[]),'
    )
    worker = f'sh("touch {bench.folder}/worker_ran; exec sleep 60", name="worker"),'
    return bench.launch(f"{worker}{node}", *words)


def go(bench: ControlBench) -> None:
    (bench.folder / "go").touch()


def helper_of(run: ControlledRun) -> psutil.Process | None:
    """The process that looks at the graph."""
    for child in psutil.Process(run.process.pid).children():
        with contextlib.suppress(psutil.Error):  # it has just ended
            if "launcher.ros.ready" in child.cmdline():
                return child
    return None


@pytest.mark.parametrize(
    "kind",
    [
        pytest.param(kind, marks=() if kind in ("node", "lifecycle") else pytest.mark.thorough)
        for kind in FACTS
    ],
)
def test_a_process_starts_when_a_node_has_what_it_waits_for(graph_bench: ControlBench, kind: str):
    fact, lack = FACTS[kind]
    rules = f"late: {{ready_when: {fact}}}\nworker: {{after: late}}\n"
    with launch(graph_bench, kind, rules) as run:
        wait_until(
            lambda: str(run.row("worker")["waiting_for"]).startswith(f"late: {lack} ("),
            f"{lack}; screen:\n{run.screen}",
        )
        assert not (graph_bench.folder / "worker_ran").exists()
        go(graph_bench)
        wait_until((graph_bench.folder / "worker_ran").exists, f"the worker:\n{run.screen}")
        assert run.row("late")["ready"] is True
        helper = helper_of(run)
        assert helper is not None
        loads_rclpy = any("_rclpy" in mapped.path for mapped in helper.memory_maps())
        assert loads_rclpy is (kind in ("message", "service", "lifecycle"))
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 0
    wait_until(lambda: not graph_bench.survivors(), "nothing is left")


def test_a_restarted_node_is_ready_only_when_its_own_publisher_is_there(graph_bench: ControlBench):
    """Not when the publisher of its last life, which was killed, is still known."""
    rules = "late: {ready_when: {publisher: /words}, restart: always}\nworker: {after: late}\n"
    go(graph_bench)
    with launch(graph_bench, "publisher", rules) as run:
        wait_until((graph_bench.folder / "worker_ran").exists, f"the worker:\n{run.screen}")
        (graph_bench.folder / "go").unlink()
        os.killpg(run.row("late")["pid"], signal.SIGKILL)
        wait_until(
            lambda: "no publisher on /words" in str(run.row("late")["lacks"]),
            f"the new node is looked at:\n{run.screen}",
        )
        assert run.row("late")["ready"] is False
        go(graph_bench)
        wait_until(lambda: run.row("late")["ready"], "it is ready again")


def test_the_process_that_looks_is_restarted_once(graph_bench: ControlBench):
    rules = (
        "late: {ready_when: {publisher: /words}}\n"
        "worker: {after: {processes: late, timeout: 600 s}}\n"
    )
    with launch(graph_bench, "publisher", rules) as run:
        wait_until(lambda: helper_of(run), "it runs")
        first = helper_of(run)
        assert first is not None
        first.kill()
        run.wait_for("the process that looks at the ROS graph died (signal 9); restarting it")
        wait_until(lambda: (other := helper_of(run)) and other.pid != first.pid, "another runs")
        go(graph_bench)
        wait_until((graph_bench.folder / "worker_ran").exists, f"the worker:\n{run.screen}")


def test_without_the_process_that_looks_the_timeout_ends_the_wait(graph_bench: ControlBench):
    rules = "late: {ready_when: {publisher: /words}}\nworker: {after: late}\n"
    with launch(graph_bench, "publisher", rules) as run:
        killed: set[int] = set()
        for _ in range(2):
            wait_until(lambda: (h := helper_of(run)) and h.pid not in killed, "it runs")
            helper = helper_of(run)
            assert helper is not None
            killed.add(helper.pid)
            helper.kill()
        run.wait_for("(signal 9); waits for ROS facts end by their timeouts")
        assert helper_of(run) is None
        waiting = run.row("worker")["waiting_for"]
        assert "late: it is not known: what looks at the ROS graph has died" in waiting
        run.process.send_signal(signal.SIGINT)
        assert run.exit_code() == 0


def test_a_killed_launcher_leaves_no_process_that_looks(graph_bench: ControlBench):
    rules = "late: {ready_when: {message: /words}}\nworker: {after: late}\n"
    with launch(graph_bench, "message", rules) as run:
        wait_until(lambda: helper_of(run), "it runs")
        run.process.kill()
        run.process.wait()
        wait_until(lambda: not graph_bench.survivors(), "nothing is left")


def test_where_discovery_is_not_plain_rclpy_looks(graph_bench: ControlBench, tmp_path: Path):
    profile = tmp_path / "profile.xml"
    profile.write_text(
        '<?xml version="1.0"?><profiles xmlns="http://www.eprosima.com"></profiles>',
        encoding="utf-8",
    )
    graph_bench.env["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(profile)
    rules = "late: {ready_when: {publisher: /words}}\nworker: {after: late}\n"
    with launch(graph_bench, "publisher", rules) as run:
        wait_until(
            lambda: "no publisher on /words" in str(run.row("worker")["waiting_for"]), "it waits"
        )
        go(graph_bench)
        wait_until((graph_bench.folder / "worker_ran").exists, f"the worker:\n{run.screen}")


def test_a_run_whose_facts_need_no_graph_does_not_look_at_it(graph_bench: ControlBench):
    rules = "late: {ready_when: {log: never}}\nworker: {after: late}\n"
    with launch(graph_bench, "publisher", rules) as run:
        wait_until(lambda: run.row("late")["pid"], "it runs")
        assert helper_of(run) is None
