"""What a run with --discovery prepares."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from launcher.commands.launch import hosts
from launcher.commands.launch.target import LaunchRequest
from launcher.errors import UsageError
from launcher.hosts import discovery_server
from launcher.hosts.discovery import MAX_WITH_PEERS
from launcher.model.options import RunOptions
from launcher.model.spec import RestartMode

NODES = """launch:
{}"""


@pytest.fixture(autouse=True)
def environment(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is prepared sets variables of this process."""
    monkeypatch.setattr(os, "environ", dict(os.environ))


def request_of(folder: Path, count: int) -> LaunchRequest:
    file = folder / "many.launch.yaml"
    one = "- node: {{pkg: group_gp1, exec: robot_1, name: n{0}}}\n"
    file.write_text(NODES.format("".join(map(one.format, range(count)))))
    return LaunchRequest(path=str(file))


def options(folder: Path, mode: str) -> RunOptions:
    file = folder / "hosts.yaml"
    file.write_text('hosts: {bot: {address: 127.0.0.1}}\nplace: {"/n*": bot}\n')
    return RunOptions(hosts=str(file), discovery=mode)


@pytest.mark.parametrize(("count", "warns"), [(MAX_WITH_PEERS, False), (MAX_WITH_PEERS + 1, True)])
def test_more_nodes_on_a_host_than_peers_can_find_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], count: int, warns: bool
):
    hosts.prepare(request_of(tmp_path, count), options(tmp_path, "peers"))
    assert ("nodes on bot: with peers, only 32" in capsys.readouterr().err) == warns


def test_the_server_is_a_process_that_restarts_without_hosts_too(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
):
    monkeypatch.setattr(discovery_server, "find", lambda environ, prefix: "/bin/true")
    prepared = hosts.prepare(request_of(tmp_path, 1), RunOptions(discovery="server"))
    (service,) = prepared.services
    assert prepared.fleet is None
    assert service.name == "discovery-server"
    assert service.argv[:3] == (sys.executable, "-m", "launcher.hosts.discovery_server")
    assert (service.restart.mode, service.restart.delay_s) == (RestartMode.ALWAYS, 21.0)
    assert os.environ["ROS_DISCOVERY_SERVER"].startswith("127.0.0.1:")


def test_without_the_program_nothing_is_started(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.setattr(discovery_server, "find", lambda environ, prefix: None)
    with pytest.raises(UsageError, match="the discovery server is not installed"):
        hosts.prepare(request_of(tmp_path, 1), RunOptions(discovery="server"))
