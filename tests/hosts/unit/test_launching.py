"""What a run with --hosts or --discovery prepares."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from launcher.base.errors import LauncherError, UsageError
from launcher.base.model.run_options import RunOptions
from launcher.base.model.spec import ProcessSpec, RestartMode
from launcher.hosts import discovery_server
from launcher.hosts.discovery import MAX_WITH_PEERS
from launcher.hosts.engine.fleet import FleetPlan
from launcher.hosts.launching.hosts_preparation import HostsPreparation
from launcher.language import frontends
from launcher.language.compat import vocabulary
from launcher.language.interpreter import Interpreter
from launcher.launch.launch_core import LaunchCore
from launcher.launch.target import LaunchRequest

HEAD = """\
from launch import LaunchDescription
from launch.actions import *
from launch.conditions import *
from launch.event_handlers import *
from launch.substitutions import *
from launch_ros.actions import Node


def node(name, **more):
    return Node(package="group_gp1", executable="robot_1", name=name, **more)


def function(*entities):
    return OpaqueFunction(function=lambda context: entities)


def generate_launch_description():
    return LaunchDescription([
"""
HOSTS = "hosts: {bot: 127.0.0.1, far: 127.0.0.2}\nplace: {here: local, a: bot, b: far}\n"
Fleet = Callable[..., FleetPlan]


@pytest.fixture(autouse=True)
def environment(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is prepared sets variables of this process."""
    monkeypatch.setattr(os, "environ", dict(os.environ))


@pytest.fixture
def fleet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Fleet:
    """The hosts that a run of these actions has prepared."""
    monkeypatch.chdir(tmp_path)

    def prepare(actions: str, hosts_text: str = HOSTS, **more: Any) -> FleetPlan:
        Path("hosts.yaml").write_text(hosts_text)
        Path("a.launch.py").write_text(f"{HEAD}{actions}\n])\n")
        request = LaunchRequest(path="a.launch.py")
        prepared = HostsPreparation(RunOptions(hosts="hosts.yaml", **more))
        with vocabulary(["a.launch.py"]):
            description = frontends.load("a.launch.py")
            interpreter = Interpreter(description, path="a.launch.py")
            interpreter.note_scopes()
            core = LaunchCore(interpreter, description, request)
            core.evaluate()
            found = prepared.fleet(core, request)
            interpreter.close()
        assert found is not None
        return found

    return prepare


def needed(found: FleetPlan) -> list[str]:
    return [host.name for host in found.needed]


@pytest.mark.parametrize(
    "later",
    [
        'node("b")',
        'TimerAction(period=9.0, actions=[node("b")])',
        'TimerAction(period=9.0, actions=[TimerAction(period=1.0, actions=[node("b")])])',
        'GroupAction([TimerAction(period=9.0, actions=[GroupAction([node("b")])])])',
        'ExecuteProcess(cmd=["x"], on_exit=[node("b")])',
        'RegisterEventHandler(OnProcessExit(on_exit=[node("b")]))',
        'RegisterEventHandler(OnProcessStart(on_start=[node("b")]))',
        'function(TimerAction(period=9.0, actions=[node("b")]))',
        'TimerAction(period=9.0, actions=[node("b", condition=IfCondition("1"))])',
        'TimerAction(period=9.0, actions=[node("b", condition=IfCondition(Command("false")))])',
    ],
)
def test_hosts_of_what_comes_later_are_connected_to_from_the_start(
    fleet: Fleet, later: str, capsys: pytest.CaptureFixture[str]
):
    assert needed(fleet(f'node("here"), node("a"), {later},')) == ["bot", "far"]
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    "off",
    [
        'node("b", condition=IfCondition("0"))',
        'TimerAction(period=9.0, actions=[node("b", condition=IfCondition("0"))])',
        'TimerAction(period=9.0, actions=[node("b")], condition=IfCondition("0"))',
    ],
)
def test_hosts_of_what_a_condition_keeps_away_are_not_connected_to(fleet: Fleet, off: str):
    found = fleet(f'node("here"), node("a"), {off},')
    assert needed(found) == ["bot"]


UNFORESEEN = 'TimerAction(period=9.0, actions=[function(node("b"))])'


def test_a_rule_for_what_a_function_starts_later_is_a_warning(
    fleet: Fleet, capsys: pytest.CaptureFixture[str]
):
    found = fleet(f'node("here"), node("a"), {UNFORESEEN},')
    assert needed(found) == ["bot"]
    assert "hosts.yaml:2: 'b' matches nothing that can be foreseen" in capsys.readouterr().err
    spec = ProcessSpec(name="b-1", label="b", argv=(), env={})
    assert found.host_of(spec).name == "far"  # when it is started


def test_a_rule_that_nothing_can_match_is_an_error(fleet: Fleet):
    timer = 'TimerAction(period=9.0, actions=[node("c")])'
    with pytest.raises(UsageError, match="'b' matches no process"):
        fleet(f'node("here"), node("a"), {timer},')


def test_two_hosts_for_what_comes_later_are_an_error(fleet: Fleet):
    rules = HOSTS.replace("b: far", '"b*": far, "*b": bot')
    with pytest.raises(LauncherError, match="two hosts for robot_1"):
        fleet('node("here"), node("a"), TimerAction(period=9.0, actions=[node("b")]),', rules)


def test_an_address_that_is_not_needed_may_be_missing(fleet: Fleet):
    lost = HOSTS.replace("127.0.0.2", "no.such.host.invalid")
    found = fleet(
        'node("here"), node("a"), node("b", condition=IfCondition("0")),', lost, discovery="peers"
    )
    assert list(found.environments) == ["bot"]
    with pytest.raises(UsageError, match=r"the address .* of far cannot"):
        fleet('node("here"), node("a"), node("b"),', lost, discovery="peers")
    found = fleet(f'node("here"), node("a"), {UNFORESEEN},', lost, discovery="peers")
    with pytest.raises(UsageError, match=r"the address .* of far cannot"):
        found.host_of(ProcessSpec(name="b-1", label="b", argv=(), env={}))


def test_each_host_of_the_file_gets_the_variables_for_discovery(fleet: Fleet):
    found = fleet(f'node("here"), node("a"), {UNFORESEEN},', discovery="peers")
    peers = {name: env["ROS_STATIC_PEERS"] for name, env in found.environments.items()}
    assert {name: "127.0.0.2" in value for name, value in peers.items()} == {
        "bot": True,
        "far": False,
    }
    assert os.environ["ROS_STATIC_PEERS"] == "127.0.0.1;127.0.0.2"


@pytest.mark.parametrize(("count", "warns"), [(MAX_WITH_PEERS, False), (MAX_WITH_PEERS + 1, True)])
def test_more_nodes_on_a_host_than_peers_can_find_are_told(
    fleet: Fleet, capsys: pytest.CaptureFixture[str], count: int, warns: bool
):
    nodes = f"*[node(f'n{{number}}') for number in range({count})],"
    fleet(nodes, 'hosts: {bot: 127.0.0.1}\nplace: {"/n*": bot}\n', discovery="peers")
    assert ("nodes on bot: with peers, only 32" in capsys.readouterr().err) == warns


def test_the_server_is_a_process_that_restarts_without_hosts_too(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setattr(discovery_server, "find", lambda environ, prefix: "/bin/true")
    (service,) = HostsPreparation(RunOptions(discovery="server")).services
    assert service.name == "discovery-server"
    assert service.argv[:3] == (sys.executable, "-m", "launcher.hosts.discovery_server")
    assert (service.restart.mode, service.restart.delay_s) == (RestartMode.ALWAYS, 21.0)
    assert os.environ["ROS_DISCOVERY_SERVER"].startswith("127.0.0.1:")


def test_without_the_program_nothing_is_started(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(discovery_server, "find", lambda environ, prefix: None)
    with pytest.raises(UsageError, match="the discovery server is not installed"):
        HostsPreparation(RunOptions(discovery="server"))
