"""`node ps`: the process of each node; stopped, busy and killed nodes."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest
from std_srvs.srv import Trigger

from launcher.ros.discovery.gids import all_live, find_pid, innermost_pid, scheme_holds
from launcher.ros.discovery.observer import Observer
from launcher.ros.node_tables import rows
from launcher.ros.service_caller import NoAnswerError, ServiceCaller
from tests.ros.ros.test_discovery_reader import threads_stand_still
from tests.support.ros_domain import ros_domain, talking
from tests.support.verbs import launcher
from tests.support.waiting import wait_until


@pytest.fixture(scope="module")
def sleepy(tmp_path_factory) -> Iterator[tuple[dict[str, str], int]]:
    """A domain with sample nodes that the tests may stop and kill, and their process."""
    with (
        ros_domain(tmp_path_factory.mktemp("ps_log")) as env,
        talking(env, "tests.support.sample_nodes") as program,
    ):
        yield env, program.pid


def ps(env: dict[str, str], *words: str) -> dict[str, dict[str, object]]:
    rows = launcher(env, "node", "ps", "--json", *words).json()["nodes"]
    return {row["name"]: row for row in rows}


def test_endpoint_ids_tell_the_process_on_ourselves(observer):
    assert scheme_holds(observer.own_gid(), os.getpid())


def test_ps_finds_the_process_of_every_node(sleepy):
    env, pid = sleepy
    rows: dict[str, dict[str, object]] = {}

    def all_answer() -> bool:
        rows.clear()
        rows.update(ps(env))
        return len(rows) == 3 and all(row["liveness"] == "ok" for row in rows.values())

    wait_until(all_answer, "three nodes answer")
    assert set(rows) == {"/talker", "/site/east/listener", "/twin"}
    talker = rows["/talker"]
    assert (talker["pid"], talker["liveness"]) == (pid, "ok")
    assert talker["program"] == "tests.support.sample_nodes"
    assert talker["uss_bytes"] > 10_000_000


def test_the_table_has_a_row_per_node(sleepy):
    env, pid = sleepy
    lines = launcher(env, "node", "ps", "--spin-time", "60").lines
    heads = ["NODE", "PROCESS", "PID", "RUN", "CPU", "USS", "UPTIME", "LIVENESS"]
    assert lines[0].split() == heads
    assert any(line.startswith("/talker ") and f" {pid} " in line for line in lines)


def test_a_node_whose_executor_is_occupied_is_busy(sleepy):
    env, _ = sleepy
    with Observer(int(env["ROS_DOMAIN_ID"])) as observer, ServiceCaller(observer) as caller:

        def liveness(timeout_s: float) -> dict[str, str]:
            found = rows(caller, hidden=False, timeout_s=timeout_s)
            return {row.node: row.liveness for row in found}

        def is_busy() -> bool:
            # our second question may come first, and to be occupied does not last for ever
            with contextlib.suppress(NoAnswerError):
                caller.start(Trigger, "/occupy", Trigger.Request())
            return liveness(0.2).get("/talker") == "busy"

        wait_until(lambda: liveness(1.0).get("/talker") == "ok", "it is known and answers")
        wait_until(is_busy, "it is occupied")


def test_a_process_that_was_suspended_earlier_is_reported_as_stopped(sleepy):
    env, pid = sleepy
    os.kill(pid, signal.SIGSTOP)
    try:
        wait_until(lambda: threads_stand_still(pid), "no thread can answer any more")
        row = ps(env, "--spin-time", "0.5")["(not discovered)"]
        assert (row["pid"], row["liveness"]) == (pid, "stopped")
    finally:
        os.kill(pid, signal.SIGCONT)


@pytest.mark.thorough
def test_a_long_running_observer_reports_stopped_nodes_and_ghosts(tmp_path):
    with (
        ros_domain(tmp_path) as env,
        Observer(int(env["ROS_DOMAIN_ID"])) as observer,
        talking(env, "tests.support.sample_nodes") as program,
        ServiceCaller(observer) as caller,
    ):

        def liveness() -> set[str]:
            return {row.liveness for row in rows(caller, hidden=False, timeout_s=0.2)}

        wait_until(lambda: liveness() == {"ok"}, "all nodes are known and answer")
        os.kill(program.pid, signal.SIGSTOP)
        wait_until(lambda: liveness() == {"stopped"}, "it is stopped")
        os.kill(program.pid, signal.SIGKILL)
        program.wait()
        wait_until(lambda: liveness() == {"ghost"}, "it is gone")
        assert set(observer.topic_graph().ghosts) >= {"/talker", "/site/east/listener"}


def test_a_participant_without_a_process_is_not_live(observer):
    own, domain_id = observer.own_gid(), observer.domain_id
    wait_until(
        lambda: all_live(observer.participants(), own, domain_id), "whoever left is forgotten"
    )
    gone = own[:4] + b"\1\0" + bytes(6)  # of this machine, by a process that is not there
    assert not all_live(observer.participants() | {gone}, own, domain_id)


def test_a_process_without_a_bound_socket_is_no_node():
    """In a container a process has numbers of its own, that are somebody else's outside."""
    program = "import socket, sys; {}; print('ready', flush=True); sys.stdin.read()"
    for setup, talks in (("pass", False), ("one = socket.socket(type=socket.SOCK_DGRAM)", True)):
        bound = f"{setup}; one.bind(('127.0.0.1', 0))" if talks else setup
        with subprocess.Popen(
            [sys.executable, "-c", program.format(bound)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        ) as child:
            assert child.stdout is not None
            child.stdout.readline()
            found = find_pid(child.pid & 0xFFFF, 0)
            child.communicate()
        assert found == (child.pid if talks else None)


def test_a_process_knows_its_innermost_number():
    assert innermost_pid(os.getpid()) == os.getpid()
    with subprocess.Popen(["true"]) as child:
        child.wait()
    assert innermost_pid(child.pid) == 0


def test_output_of_the_middleware_goes_to_stderr():
    program = """
import os
from launcher.posix.stdio import stdout_to_stderr
print("before")
with stdout_to_stderr():
    os.write(1, b"complaint")
os.write(1, b"answer")
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("before\nanswer", "complaint")
