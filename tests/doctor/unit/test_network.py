"""What the doctor says about discovery."""

from __future__ import annotations

from typing import Any

import pytest

from launcher.base.model.level import Level
from launcher.doctor.doctor_facts import Finding, NetworkFacts, ParticipantProcess
from launcher.doctor.network_checks import check_network
from launcher.doctor.network_facts import _unknown_servers

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"


def found(name: str, **facts: Any) -> Finding:
    (finding,) = [one for one in check_network(NetworkFacts(**facts)) if one.name == name]
    assert (finding.advice is None) == (finding.level is Level.OK)
    return finding


def test_nothing_unusual_is_no_finding():
    findings = check_network(NetworkFacts(addresses=("10.0.0.1",), is_in_step=True))
    assert {finding.level for finding in findings} == {Level.OK}


@pytest.mark.parametrize(
    ("settings", "level"),
    [
        ({"ROS_STATIC_PEERS": "10.0.0.2", RANGE: "LOCALHOST"}, Level.OK),
        ({"ROS_STATIC_PEERS": "10.0.0.2"}, Level.NOTE),
        ({"ROS_STATIC_PEERS": "10.0.0.2", RANGE: "SYSTEM_DEFAULT"}, Level.PROBLEM),
        ({"ROS_STATIC_PEERS": "10.0.0.2", RANGE: "OFF"}, Level.PROBLEM),
        ({"ROS_STATIC_PEERS": "10.0.0.2", "ROS_LOCALHOST_ONLY": "1"}, Level.PROBLEM),
        ({RANGE: "OFF"}, Level.PROBLEM),
        ({"ROS_DISCOVERY_SERVER": "10.0.0.2:11811"}, Level.OK),
    ],
)
def test_settings_that_have_no_effect(settings: dict[str, str], level: Level):
    assert found("discovery", settings=settings).level is level


def test_a_peer_that_cannot_be_resolved_keeps_nodes_from_starting():
    settings = {"ROS_STATIC_PEERS": "bot7", RANGE: "LOCALHOST"}
    finding = found("discovery", settings=settings, unknown_peers=("bot7",))
    assert finding.level is Level.PROBLEM and "no node can start" in finding.text


@pytest.mark.parametrize(
    ("text", "unknown"),
    [
        ("127.0.0.1:11811", ()),
        (";;127.0.0.1", ()),
        ("[::1]:11811;TCPv4:[10.0.0.1]:42100", ()),
        ("no host:11811;127.0.0.1:11811", ("no host:11811",)),
        ("127.0.0.1:99999", ("127.0.0.1:99999",)),
        ("127.0.0.1:port", ("127.0.0.1:port",)),
    ],
)
def test_entries_that_are_no_address_of_a_server(text: str, unknown: tuple[str, ...]):
    assert tuple(_unknown_servers(text)) == unknown
    finding = found("discovery", settings={"ROS_DISCOVERY_SERVER": text}, unknown_servers=unknown)
    assert finding.level is (Level.PROBLEM if unknown else Level.OK)


def test_without_loopback_nodes_do_not_find_each_other():
    finding = found("loopback", loopback_fault="Network is unreachable")
    assert finding.level is Level.PROBLEM and "(Network is unreachable)" in finding.text
    assert "ip link set lo up" in (finding.advice or "")


@pytest.mark.parametrize(
    ("settings", "level"),
    [
        ({}, Level.PROBLEM),
        ({RANGE: "LOCALHOST"}, Level.NOTE),
        ({"ROS_STATIC_PEERS": "a"}, Level.NOTE),
    ],
)
def test_blocked_multicast_is_a_problem_where_it_is_used(settings: dict[str, str], level: Level):
    blocked = ("10.0.0.1",)
    finding = found("multicast", settings=settings, addresses=blocked, without_multicast=blocked)
    assert finding.level is level


def test_nodes_with_another_shared_memory_are_named():
    node = ParticipantProcess(pid=7, command="talker", domain=0, shares_memory=False)
    finding = found("shared memory of nodes", nodes=(node,))
    assert finding.level is Level.PROBLEM and "talker [7]" in finding.text
    udp = {"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
    careful = ParticipantProcess(
        pid=7, command="talker", domain=0, settings=udp, shares_memory=False
    )
    assert found("shared memory of nodes", nodes=(careful,)).level is Level.OK
    unknown = ParticipantProcess(pid=7, command="talker", domain=0)
    assert found("shared memory of nodes", nodes=(unknown,)).level is Level.OK


def node(domain: int = 0, **settings: str) -> ParticipantProcess:
    return ParticipantProcess(
        pid=7, command="talker", domain=domain, settings=settings, shares_memory=True
    )


@pytest.mark.parametrize(
    ("nodes", "settings", "words"),
    [
        ((node(),), {}, None),
        ((node(3),), {}, "ROS_DOMAIN_ID is 0, but running nodes use 3"),
        ((node(3), node()), {}, None),
        ((node(RMW_IMPLEMENTATION="rmw_x"),), {}, "talker [7] uses rmw_x"),
        ((node(ROS_DISTRO="humble"),), {"ROS_DISTRO": "jazzy"}, "is of ROS humble"),
        ((node(ROS_DISTRO="humble"),), {}, None),
    ],
)
def test_nodes_that_this_shell_would_not_see(
    nodes: tuple[ParticipantProcess, ...], settings: dict[str, str], words: str | None
):
    finding = found("other nodes", nodes=nodes, settings=settings)
    assert finding.level is (Level.OK if words is None else Level.NOTE)
    assert words is None or words in finding.text


def test_more_nodes_than_find_each_other_are_a_problem():
    crowd = (node(**{RANGE: "LOCALHOST"}),) * 34
    finding = found("number of nodes", nodes=crowd)
    assert finding.level is Level.PROBLEM
    assert finding.text.startswith("34 nodes on domain 0 do not all find each other: ")
    assert finding.advice == f"use --discovery server, or {RANGE}=SUBNET"
    assert found("number of nodes", nodes=crowd[1:]).level is Level.OK
    served = node(ROS_DISCOVERY_SERVER="127.0.0.1:11811", FASTRTPS_DEFAULT_PROFILES_FILE="/x.xml")
    assert found("number of nodes", nodes=(served,) * 120).level is Level.OK


def test_a_clock_that_nobody_keeps_is_noted():
    assert found("clock", is_in_step=False).level is Level.NOTE
    assert found("clock", is_in_step=None).level is Level.OK
