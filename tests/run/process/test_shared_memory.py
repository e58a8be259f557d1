"""Shared memory of real rclpy nodes: only that of ended nodes is freed."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from launcher.posix import proc
from launcher.posix.cleanup import RUN_ID_VARIABLE
from launcher.posix.domain_lease import leased_domain
from launcher.run.monitor.ledger import Ledger
from launcher.run.monitor.shared_memory import FOLDER, free, held, stale
from tests.support.waiting import wait_until
from tests.support.web_page import PageClient, run_with_page

pytestmark = pytest.mark.alone

RUN_ID = f"{os.getpid()}-shm"
NODE = """
import os, sys, rclpy
rclpy.init()
node = rclpy.create_node("n")
node.create_publisher(__import__("std_msgs.msg").msg.String, "t", 1)
if "fork" in sys.argv and os.fork() == 0:
    __import__("signal").pause()
try:
    print(f"ready {os.getpid()}", flush=True)
    rclpy.spin(node)
except KeyboardInterrupt:
    node.destroy_node()
    rclpy.try_shutdown()
"""


class Nodes:
    """Real nodes in one domain of their own."""

    def __init__(self, env: dict[str, str]) -> None:
        self.env = env
        self.names: set[str] = set()
        self._started: list[subprocess.Popen[str]] = []

    def start(self, *words: str, shell: bool = False) -> subprocess.Popen[str]:
        """A node that has all its files; behind a shell that waits for it, if asked."""
        command = [sys.executable, "-c", NODE, *words]
        if shell:
            command = ["sh", "-c", '"$@"; :', "sh", *command]
        node = subprocess.Popen(
            command, env=self.env, stdout=subprocess.PIPE, text=True, start_new_session=True
        )
        self._started.append(node)
        return node

    def of(self, pid: int) -> set[str]:
        """What the process holds in shared memory, apart from ports that all domains share."""
        names = {name for name, owner in held().items() if owner == pid and is_private(name)}
        self.names |= names
        return names

    def close(self) -> None:
        for node in self._started:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(node.pid, signal.SIGKILL)  # a child may have outlived it
            node.wait()
            node.stdout.close()
        segments = {name for name in self.names if "_port" not in name}
        wait_until(
            lambda: free(self.names) >= 0 and not any(map(exists, segments)),
            "their children are dead, too",
        )


@pytest.fixture
def nodes(tmp_path: Path) -> Iterator[Nodes]:
    with leased_domain() as domain_id:
        env = {
            **os.environ,
            "ROS_DOMAIN_ID": str(domain_id),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(tmp_path),
            RUN_ID_VARIABLE: RUN_ID,
        }
        some = Nodes(env)
        yield some
        some.close()


def is_private(name: str) -> bool:
    """Whether nobody in another domain uses it: ports below 7400 are everybody's."""
    _, _, port = name.partition("_port")
    return not port or int(port) >= 7400


def pid_from(node: subprocess.Popen[str]) -> int:
    """The pid that the node prints when it is ready."""
    for line in node.stdout:
        if line.startswith("ready"):
            return int(line.split()[1])
    raise AssertionError("the node ended before it was ready")


def kill(pid: int, node: subprocess.Popen[str]) -> None:
    os.kill(pid, signal.SIGKILL)
    node.wait(60)


def stale_names() -> set[str]:
    """What is stale, once its files are no longer new."""
    return {item.name for item in stale(now_s=time.time() + 60)}


def exists(name: str) -> bool:
    return (Path(FOLDER) / name).exists() or (Path(FOLDER) / f"{name}_el").exists()


def test_what_a_live_node_holds_is_not_stale_and_not_freed(nodes: Nodes):
    pid = pid_from(nodes.start())
    names = nodes.of(pid)
    assert {"_port" in name for name in names} == {True, False}
    assert names.isdisjoint(stale_names())
    assert free(names) == 0
    assert all(map(exists, names))


def test_a_node_that_ends_in_order_leaves_nothing(nodes: Nodes):
    node = nodes.start()
    names = nodes.of(pid_from(node))
    node.send_signal(signal.SIGINT)
    assert node.wait(60) == 0
    assert not any(map(exists, names))


def test_what_a_killed_node_leaves_is_found_and_freed(nodes: Nodes):
    node = nodes.start()
    names = nodes.of(pid_from(node))
    kill(node.pid, node)
    # Ports are left alone as long as anybody's participant on this machine is just starting.
    wait_until(lambda: names <= stale_names(), "all that it held is stale")
    freed = []
    wait_until(
        lambda: freed.append(free(names)) or not any(map(exists, names)), "all of it is freed"
    )
    assert sum(freed) > 500_000


def test_the_tracker_frees_segments_of_ended_processes_only(nodes: Nodes):
    ledger = Ledger(RUN_ID)
    dead, alive = nodes.start(), nodes.start()
    names_of_dead, names_of_alive = nodes.of(pid_from(dead)), nodes.of(pid_from(alive))
    ledger.note()
    kill(dead.pid, dead)
    ledger.died(-signal.SIGKILL, time.time())
    assert ledger.free() > 500_000
    assert not any(exists(name) for name in names_of_dead if "_port" not in name)
    assert nodes.of(alive.pid) == names_of_alive
    alive.send_signal(signal.SIGINT)
    assert alive.wait(60) == 0
    names = names_of_dead | names_of_alive
    wait_until(
        lambda: ledger.free(is_last=True) == 0 and not any(map(exists, names)), "all is freed"
    )
    assert not any(filter(is_private, ledger.names))


def test_a_grandchild_is_tracked_and_an_unrelated_process_is_not(nodes: Nodes):
    ledger = Ledger(RUN_ID)
    pid = pid_from(nodes.start(shell=True))
    nodes.env[RUN_ID_VARIABLE] = "1-other"
    stranger = pid_from(nodes.start())
    ledger.note()
    assert nodes.of(pid) <= ledger.names
    assert nodes.of(stranger).isdisjoint(ledger.names)


def test_a_lock_that_a_forked_child_keeps_is_respected(nodes: Nodes):
    node = nodes.start("fork")
    names = nodes.of(pid_from(node))
    kill(node.pid, node)  # its child lives on, with the memory and the locks
    assert names.isdisjoint(stale_names())
    assert free(names) == 0


def test_a_run_whose_helpers_outlive_its_nodes_leaves_no_port(tmp_path: Path):
    """The reference count of a port does not get 0 if one who had opened it was killed."""
    with leased_domain() as domain_id, tempfile.TemporaryDirectory(dir="/tmp") as runtime:
        env = {
            **os.environ,
            "ROS_DOMAIN_ID": str(domain_id),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(tmp_path),
        }

        def ports() -> list[str]:
            numbers = range(7400 + 250 * domain_id, 7650 + 250 * domain_id)
            return [
                name
                for name in os.listdir(FOLDER)
                if (found := re.search(r"_port(\d+)", name)) and int(found[1]) in numbers
            ]

        def knows(page: PageClient, *names: str) -> bool:
            graphs = page.of("graph")
            known = {node["name"] for node in graphs[-1]["nodes"]} if graphs else set()
            return {*names} <= known

        words = ["--record", "--responsive"]
        with run_with_page("system", words, env, Path(runtime), tmp_path / "screen") as (run, link):
            with PageClient(link) as page:
                page.open()
                wait_until(lambda: knows(page, "/robot_1", "/robot_2"), "the probe knows them")
                for name in ("robot_1-3", "robot_2-4"):
                    run.ask_text("kill", name, signal="KILL")
                run.ask_text("restart", "monitor")
            assert ports()
            run.process.send_signal(signal.SIGINT)
            run.process.wait(60)
        assert ports() == []


def test_no_port_is_freed_beside_a_node_that_proc_does_not_show(
    nodes: Nodes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    dead, alive = nodes.start(), nodes.start()
    names = nodes.of(pid_from(dead))
    nodes.of(pid_from(alive))  # freed at the end
    kill(dead.pid, dead)
    monkeypatch.setattr(proc, "ROOT", str(tmp_path / "nothing to see"))
    assert free(names) > 500_000
    monkeypatch.undo()
    assert {name for name in names if exists(name)} == {n for n in names if "_port" in n}
