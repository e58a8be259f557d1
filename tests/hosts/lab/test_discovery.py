"""Discovery without multicast: real nodes on hosts in subnets of their own."""

from __future__ import annotations

import contextlib
import json
import os
import re
import select
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from launcher.hosts.discovery import MAX_WITH_PEERS, RESTART_DELAY_S, DiscoveryServer, Wiring
from launcher.hosts.file.hosts_model import LOCAL, DiscoveryMode
from tests.support.hosts import Computer, Host, Lab
from tests.support.hosts.checks import module
from tests.support.hosts.entered import Entered
from tests.support.hosts.operator import launcher_words
from tests.support.repository import REPOSITORY
from tests.support.waiting import wait_until

DOMAIN = 17  # the network is ours alone
PORT = 11811


class Acquaintance:
    """A node on a computer, and the names that it has heard, in order."""

    def __init__(
        self,
        computer: Computer,
        env: Mapping[str, str],
        name: str = "",
        wrapped: Callable[..., list[str]] = lambda *words: [*words],
    ) -> None:
        self.name = name or computer.name
        self.heard: list[str] = []
        self._process = computer.popen(
            wrapped(*module("tests.support.hosts.acquaintance", self.name)),
            env={"ROS_DOMAIN_ID": str(DOMAIN), **env},
            stdout=subprocess.PIPE,
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self.heard.append(line.strip())

    def end(self) -> None:
        self._process.send_signal(signal.SIGINT)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(10)
        self._process.kill()
        self._process.wait()
        self._reader.join()


class Meeting:
    """Nodes that are ended together."""

    def __init__(self, wiring: Wiring) -> None:
        self._wiring = wiring
        self.nodes: list[Acquaintance] = []

    def join(self, *computers: Computer) -> None:
        for computer in computers:
            name = LOCAL if computer.name == "operator" else computer.name
            env = self._wiring.environment_of(name)
            self.nodes.append(Acquaintance(computer, env))

    @property
    def is_complete(self) -> bool:
        names = {node.name for node in self.nodes}
        return all(names <= set(node.heard) for node in self.nodes)

    def wait(self) -> None:
        wait_until(lambda: self.is_complete, "all nodes hear each other")

    def wait_for_more(self) -> None:
        """All hear all others again."""
        before = {node.name: len(node.heard) for node in self.nodes}
        names = {node.name for node in self.nodes}

        def is_so() -> bool:
            return all(names <= set(node.heard[before[node.name] :]) for node in self.nodes)

        wait_until(is_so, "all nodes hear each other again")


@contextlib.contextmanager
def meeting(wiring: Wiring, *computers: Computer) -> Iterator[Meeting]:
    found = Meeting(wiring)
    try:
        found.join(*computers)
        yield found
    finally:
        for node in found.nodes:
            node.end()


@contextlib.contextmanager
def server(computer: Computer, index: int) -> Iterator[Entered]:
    words = module("launcher.hosts.discovery_server", str(index), "0.0.0.0", str(PORT))
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    with computer.popen(words, **pipes) as process:
        try:
            assert process.stdout is not None
            assert select.select([process.stdout], [], [], 60)[0], "the server says nothing"
            assert "Server is running" in process.stdout.readline()
            yield process
        finally:
            process.kill()  # or a test that fails would wait for it


@pytest.fixture(scope="module")
def one(lab: Lab) -> Host:
    return lab.host("one", routed=True)


@pytest.fixture(scope="module")
def two(lab: Lab) -> Host:
    return lab.host("two", routed=True)


def wired(lab: Lab, mode: DiscoveryMode, *hosts: Host, servers: tuple[str, ...] = ()) -> Wiring:
    return Wiring(
        mode=mode,
        addresses={host.name: host.address for host in hosts},
        own={host.name: lab.operator.address for host in hosts},
        servers=tuple(
            DiscoveryServer(
                name=f"server-{index}", host=host, index=index, port=PORT, listen="0.0.0.0"
            )
            for index, host in enumerate(servers)
        ),
    )


def test_peers_meet_over_routed_subnets(lab: Lab, one: Host, two: Host):
    wiring = wired(lab, DiscoveryMode.PEERS, one, two)
    with meeting(wiring, lab.operator, one, two) as nodes:
        nodes.wait()


def test_peers_meet_on_hosts_with_many_participants(lab: Lab, one: Host, two: Host):
    """With another discovery range, only the first 4 of a host would be found."""
    words = module("tests.support.hosts.held_ports", str(DOMAIN), str(MAX_WITH_PEERS - 1))
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with one.popen(words, **pipes) as first, two.popen(words, **pipes) as second:
        for holder in (first, second):
            assert holder.stdout is not None
            assert holder.stdout.readline() == "held\n"
        with meeting(wired(lab, DiscoveryMode.PEERS, one, two), one, two) as nodes:
            nodes.wait()
        for holder in (first, second):
            holder.communicate(timeout=60)


def test_nodes_meet_through_a_server_here_and_go_on_when_it_is_killed(
    lab: Lab, one: Host, two: Host
):
    wiring = wired(lab, DiscoveryMode.SERVER, one, two, servers=(LOCAL,))
    with server(lab.operator, 0) as process, meeting(wiring, lab.operator, one, two) as nodes:
        nodes.wait()
        process.kill()
        process.wait()
        nodes.wait_for_more()


def test_nodes_that_start_before_the_server_meet_when_it_is_up(lab: Lab, one: Host, two: Host):
    wiring = wired(lab, DiscoveryMode.SERVER, one, two, servers=("one",))
    with meeting(wiring, lab.operator, two) as nodes:
        wait_until(lambda: all(node.heard for node in nodes.nodes), "both nodes are up")
        assert not nodes.is_complete
        with server(one, 0):
            nodes.wait()


def test_the_backup_serves_new_nodes_when_the_server_is_killed(lab: Lab, one: Host, two: Host):
    wiring = wired(lab, DiscoveryMode.SERVER, one, two, servers=("one", LOCAL))
    with server(one, 0) as first, server(lab.operator, 1), meeting(wiring, one, two) as nodes:
        nodes.wait()
        first.kill()
        first.wait()
        nodes.join(lab.operator)
        nodes.wait()


def test_the_whole_graph_is_seen_through_the_server(lab: Lab, one: Host, two: Host):
    wiring = wired(lab, DiscoveryMode.SERVER, one, two, servers=(LOCAL,))
    env = {"ROS_DOMAIN_ID": str(DOMAIN), **wiring.environment_of()}

    def shown(*words: str) -> str:
        return str(lab.operator.launcher(*words, env=env).stdout)

    with server(lab.operator, 0), meeting(wiring, one, two) as nodes:
        nodes.wait()
        wait_until(lambda: shown("node", "list").split() == ["/one", "/two"], "all nodes are seen")
        wait_until(
            lambda: "Publisher count: 2" in shown("topic", "info", "/names"), "both publishers"
        )


# ---- a container with the network of its host


def in_box(*words: str) -> list[str]:
    """The words of a command with the addresses of its host, and a /dev/shm of its own."""
    unshare = ["unshare", "--mount", "--propagation", "private", "sh", "-c"]
    return [*unshare, 'mount -t tmpfs tmpfs /dev/shm; exec "$@"', "sh", *words]


class Boxed:
    """Nodes on a host and in a container on it."""

    def __init__(self, host: Host, env: Mapping[str, str]) -> None:
        self.host = Acquaintance(host, env, "host")
        self.box = Acquaintance(host, env, "box", in_box)

    def __enter__(self) -> Boxed:
        return self

    def __exit__(self, *error: object) -> None:
        self.host.end()
        self.box.end()


def test_doctor_finds_nodes_with_the_same_address_and_another_shared_memory(one: Host):
    command = [sys.executable, "-m", "launcher", "doctor", "--json"]
    udp = {"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
    with Boxed(one, {}) as nodes:
        wait_until(lambda: nodes.host.heard.count("host") > 2, "the host's node hears itself")
        wait_until(lambda: nodes.box.heard.count("box") > 2, "the container's node hears itself")
        assert "box" not in nodes.host.heard and "host" not in nodes.box.heard
        found = json.loads(one.run(command, check=False).stdout)["findings"]
    (finding,) = [one for one in found if one["check"] == "shared memory of nodes"]
    assert finding["level"] == "problem"
    assert "messages are lost without a word" in finding["text"]
    assert "FASTDDS_BUILTIN_TRANSPORTS=UDPv4" in finding["advice"]
    with Boxed(one, udp) as nodes:
        wait_until(lambda: "box" in nodes.host.heard, "the host's node hears the container's")
        wait_until(lambda: "host" in nodes.box.heard, "the container's node hears the host's")
        found = json.loads(one.run(command, check=False).stdout)["findings"]
    (finding,) = [one for one in found if one["check"] == "shared memory of nodes"]
    assert finding["level"] == "ok"


# ---- the servers of a run


class Fleet:
    """A launcher on the operator's computer; its screen is a file."""

    def __init__(self, lab: Lab, screen: Path, *words: object) -> None:
        self._operator = lab.operator
        self.env = {"ROS_DOMAIN_ID": str(DOMAIN)}
        self._screen = screen
        with screen.open("wb") as out:
            command = launcher_words(["system", *words])
            options = {"env": self.env, "cwd": REPOSITORY, "stderr": subprocess.STDOUT}
            self.process = self._operator.popen(command, stdout=out, **options)

    def __enter__(self) -> Fleet:
        return self

    def __exit__(self, *error: object) -> None:
        self.process.kill()
        self.process.wait()

    @property
    def screen(self) -> str:
        return self._screen.read_text(encoding="utf-8", errors="replace")

    def wait_for_tasks(self, robot: str, count: int) -> None:
        """Wait for a report of that many; one that began late finishes several between two."""

        def is_reported() -> bool:
            found = re.findall(rf"{robot}: (\d+) tasks", self.screen)
            return any(int(number) >= count for number in found)

        wait_until(is_reported, f"{robot} works")

    def verb(self, *words: str) -> str:
        return str(self._operator.launcher(*words, env=self.env).stdout)

    def processes(self) -> dict[str, dict[str, Any]]:
        document = json.loads(self.verb("ps", "--json"))
        return {process["name"]: process for process in document["processes"]}

    def stop(self) -> int:
        self.process.send_signal(signal.SIGINT)
        return int(self.process.wait(60))


def has_publishers(fleet: Fleet, count: int) -> bool:
    return f"Publisher count: {count}\n" in fleet.verb("topic", "info", "/fleet/status")


def test_a_run_on_this_machine_starts_a_server_for_its_nodes(lab: Lab, tmp_path: Path):
    with Fleet(lab, tmp_path / "screen", "--discovery", "server") as fleet:
        fleet.wait_for_tasks("robot_1", 1)
        names = list(fleet.processes())
        assert names[0] == "discovery-server"
        wait_until(lambda: "/robot_2" in fleet.verb("node", "list").split(), "a shell sees nodes")
        assert fleet.stop() == 0
    started = fleet.screen.index("[discovery-server]: process started")
    assert started < fleet.screen.index("[dispatcher-1]: process started")


def test_a_killed_server_is_started_again_when_its_clients_have_forgotten_it(
    lab: Lab, tmp_path: Path
):
    with Fleet(lab, tmp_path / "screen", "--discovery", "server") as fleet:
        fleet.wait_for_tasks("robot_1", 1)
        killed = fleet.processes()["discovery-server"]["pid"]
        begun_s = time.monotonic()
        os.kill(killed, signal.SIGKILL)
        reports = fleet.screen.count("Fleet report")
        wait_until(lambda: fleet.screen.count("Fleet report") > reports + 1, "the nodes go on")

        def is_back() -> bool:
            found = fleet.processes()["discovery-server"]
            return found["state"] == "RUNNING" and found["pid"] != killed

        wait_until(is_back, "the server runs again")
        assert time.monotonic() - begun_s > RESTART_DELAY_S
        wait_until(lambda: "/robot_2" in fleet.verb("node", "list").split(), "a shell sees nodes")
        fleet.stop()


def test_a_run_over_hosts_has_its_servers_where_the_hosts_file_says(
    lab: Lab, one: Host, two: Host, tmp_path: Path
):
    place = {"robot_1": "one", "robot_2": "two"}
    servers = {"mode": "server", "server": "one", "backup": LOCAL}
    file = lab.hosts_file(tmp_path / "hosts.yaml", [one, two], place, discovery=servers)
    with Fleet(lab, tmp_path / "screen", "--hosts", file) as fleet:
        for name in ("robot_1", "robot_2", "robot_3"):
            fleet.wait_for_tasks(name, 2)
        processes = fleet.processes()
        assert processes["discovery-server"]["host"] == "one"
        assert processes["discovery-backup"]["host"] == LOCAL
        wait_until(lambda: has_publishers(fleet, 3), "a shell sees all publishers")
        assert fleet.stop() == 0
    words = [process.words for process in one.processes()]
    assert not any("discovery" in " ".join(found) for found in words)


@pytest.mark.parametrize("server", [LOCAL, "one"])
def test_a_run_with_a_server_ends_with_the_processes_of_the_launch_file(
    lab: Lab, one: Host, tmp_path: Path, server: str
):
    servers = {"mode": "server", "server": server}
    file = lab.hosts_file(tmp_path / "hosts.yaml", [one], {"there": "one"}, discovery=servers)
    launch = tmp_path / "short.launch.py"
    launch.write_text(
        "from launch import LaunchDescription\n"
        "from launch.actions import ExecuteProcess\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([\n"
        "        ExecuteProcess(cmd=['sleep', '1'], name=name) for name in ('here', 'there')\n"
        "    ])\n"
    )
    words = (launch, "--hosts", file, "--no-console")
    done = lab.operator.launcher(*words, env={"ROS_DOMAIN_ID": str(DOMAIN)})

    assert done.returncode == 0, done.stdout + done.stderr
    assert "[discovery-server]: process started" in done.stdout


def test_a_run_over_routed_hosts_needs_only_peers(lab: Lab, one: Host, two: Host, tmp_path: Path):
    place = {"robot_1": "one", "robot_2": "two"}
    file = lab.hosts_file(tmp_path / "hosts.yaml", [one, two], place)
    words = ("--hosts", file, "--discovery", "peers")
    with Fleet(lab, tmp_path / "screen", *words) as fleet:
        for name in ("robot_1", "robot_2", "robot_3"):
            fleet.wait_for_tasks(name, 2)
        wait_until(lambda: has_publishers(fleet, 3), "a shell sees all publishers")
        assert fleet.stop() == 0
