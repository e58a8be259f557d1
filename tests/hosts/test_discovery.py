"""Discovery without multicast: real nodes on hosts in subnets of their own."""

from __future__ import annotations

import contextlib
import select
import signal
import subprocess
import threading
from collections.abc import Iterator, Mapping

import pytest

from launcher.hosts.discovery import MAX_WITH_PEERS, Server, Wiring
from launcher.hosts.model import LOCAL, DiscoveryMode
from tests.support.hosts import Computer, Host, Lab
from tests.support.hosts.checks import module
from tests.support.hosts.entered import Entered
from tests.support.waiting import wait_until

DOMAIN = 17  # the network is ours alone
PORT = 11811


class Acquaintance:
    """A node on a computer, and the names that it has heard, in order."""

    def __init__(self, computer: Computer, env: Mapping[str, str], name: str = "") -> None:
        self.name = name or computer.name
        self.heard: list[str] = []
        self._process = computer.popen(
            module("tests.support.hosts.acquaintance", self.name),
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
        assert process.stdout is not None
        assert select.select([process.stdout], [], [], 60)[0], "the server says nothing"
        assert "Server is running" in process.stdout.readline()
        yield process
        process.kill()


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
            Server(name=f"server-{index}", host=host, index=index, port=PORT, listen="0.0.0.0")
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
        assert "Publisher count: 2" in shown("topic", "info", "/names")
