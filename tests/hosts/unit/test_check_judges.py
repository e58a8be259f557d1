"""What the check says about facts."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

import launcher
from launcher.base.model.level import Level
from launcher.base.model.record import replace
from launcher.hosts.check.check_report import as_text
from launcher.hosts.check.examine import Examination, missing_secrets
from launcher.hosts.check.host_findings import (
    Arrival,
    CheckedHost,
    Clock,
    HostFinding,
    Needs,
    Survey,
)
from launcher.hosts.check.host_judges import check_member
from launcher.hosts.check.pair_judges import check_pairs
from launcher.hosts.failures import HostError, Problem
from launcher.hosts.file.hosts_model import LOCAL, DiscoveryMode, Host, HostEngine, Secret

GB = 1024**3


def folder(path: str, **changes: Any) -> dict[str, Any]:
    plenty = {"free": 5 * GB, "total": 9 * GB, "inodes": 10**6, "free_inodes": 10**5}
    return {"path": path, "existing": "/", "writable": True, **plenty, **changes}


def member(name: str, *, engine: HostEngine = HostEngine.AUTO, **changes: Any) -> CheckedHost:
    number = sum(map(ord, name)) % 200
    facts: dict[str, Any] = {
        "python": [3, 11, 2],
        "executable": "/usr/bin/python3",
        "machine": "x86_64",
        "uid": 1000,
        "client": "",
        "settings": {},
        "boot_id": name,
        "shared_memory": 24,
        "addresses": [f"10.0.0.{number}"],
        "ports": {"unicast": 7410, "multicast": 7400},
        "port_errors": {},
        "folders": [folder(".ros/log"), folder("/dev/shm")],
        "max_sessions": 10,
        "systemd": None,
        "manager": False,
        "lingers": False,
        "version": launcher.__version__,
        "protocol": 1,
        "code": "0a1b",
        "unchecked": "",
        "missing": {"packages": [], "executables": [], "interfaces": []},
        "rclpy": "7.1.6",
        "middlewares": ["rmw_fastrtps_cpp"],
    }
    assert changes.keys() - facts.keys() <= {"clock"}
    clock = changes.pop("clock", None)
    host = None if name == LOCAL else Host(name=name, address="10.0.0.1", engine=engine)
    return CheckedHost(
        name=name,
        host=host,
        address="10.0.0.1",
        needs=Needs(),
        user="robot",
        reached_s=0.3,
        facts={**facts, **changes},
        clock=clock,
    )


def only(findings: list[HostFinding]) -> HostFinding:
    (finding,) = findings
    assert finding.advice and finding.text[-1] != "."
    return finding


def test_missing_secrets_are_named_once_for_all_hosts(tmp_path: Path):
    there = tmp_path / "there"
    there.touch()
    secrets = {
        "A": Secret(variable="TOKEN_A"),
        "B": Secret(variable="TOKEN_B"),
        "C": Secret(file=str(there)),
        "D": Secret(file=str(tmp_path / "none")),
    }
    members = [
        replace(one, host=replace(one.host, secrets=secrets)) for one in (member("a"), member("b"))
    ]

    found = [*missing_secrets([member(LOCAL), *members], {"TOKEN_A": "s3cret"})]

    assert [one.hosts for one in found] == [(LOCAL, "a", "b")] * 2
    assert "environment variable TOKEN_B, for B" in found[0].text
    assert str(tmp_path / "none") in found[1].text


@pytest.mark.parametrize("code", ["another", None])
def test_another_state_of_the_same_version_is_a_problem(code: str | None):
    found = only(check_pairs(survey(member(LOCAL), member("a"), member("b", code=code)), None))

    assert (found.check, found.level, found.hosts) == ("launcher", Level.PROBLEM, ("b",))
    assert "hosts sync" in found.advice


def test_packages_that_cannot_be_looked_for_are_a_problem():
    one = replace(member("a", unchecked="ImportError: x"), needs=Needs(packages=("p",)))

    found = only(check_member(one))

    assert (found.check, found.level) == ("packages", Level.PROBLEM)
    assert "ImportError: x" in found.text


def survey(*members: CheckedHost, lost: tuple[tuple[str, str, str], ...] = ()) -> Survey:
    arrived = {
        Arrival(kind=kind, sender=one.name, receiver=other.name)
        for one in members
        for other in members
        for kind in other.facts["ports"]
        if one is not other and (kind, one.name, other.name) not in lost
    }
    return Survey(members={one.name: one for one in members}, arrived=frozenset(arrived))


def test_a_host_for_which_there_are_no_wheels_needs_an_installation():
    here, bot = member(LOCAL), member("bot1", rclpy=None)
    assert "hosts sync" in only(check_pairs(survey(here, bot), None)).advice
    bot = member("bot1", rclpy=None, machine="aarch64")
    advice = only(check_pairs(survey(here, bot), None)).advice
    assert advice.startswith("set `setup: /opt/ros/")
    assert "hosts sync" not in advice


@pytest.mark.parametrize(
    ("changes", "check", "words"),
    [
        ({"python": [3, 8, 10]}, "python", "Python 3.8.10 is too old"),
        ({"version": None}, "launcher", "/usr/bin/python3 has no launcher"),
        ({"max_sessions": 2}, "sessions", "2 sessions"),
        ({"folders": [folder("a", free=10**6)]}, "disk", "1 MiB are free where a is"),
        ({"folders": [folder("/dev/shm", free=10**6)]}, "disk", "1 MiB are free"),
        ({"folders": [folder("a", free_inodes=7)]}, "disk", "7 inodes are free"),
        ({"folders": [folder("a", free_inodes=1)]}, "disk", "1 inode is free"),
        ({"folders": [folder("a", writable=False)]}, "disk", "robot cannot write to /, for a"),
        ({"port_errors": {"unicast": "port 7410: in use"}}, "discovery", "no UDP port"),
    ],
)
def test_each_problem_of_a_host(changes: Mapping[str, Any], check: str, words: str):
    finding = only(check_member(member("bot", **changes)))
    assert (finding.check, finding.level) == (check, Level.PROBLEM)
    assert words in finding.text


def test_a_disk_without_a_number_of_inodes_is_fine():
    btrfs = folder("a", inodes=0, free_inodes=0)
    assert check_member(member("bot", folders=[btrfs])) == []


def test_missing_executables_of_a_missing_package_are_not_told_again():
    missing = {
        "packages": ["arm"],
        "executables": [["arm", "grip"], ["base", "drive"]],
        "interfaces": ["arm_msgs"],
    }
    text = only(check_member(member("bot", missing=missing))).text
    assert text == "not found: package arm, drive of base, message package arm_msgs"


def test_a_host_that_failed_tells_only_that():
    host = Host(name="bot", address="10.0.0.1")
    error = HostError(host, Problem.REFUSED, "refuses connections", hint="start sshd")
    failed = CheckedHost(name="bot", host=host, address="10.0.0.1", error=error)
    finding = only(check_member(failed))
    assert (finding.text, finding.advice) == ("refuses connections", "start sshd")


@pytest.mark.parametrize(
    ("engine", "facts", "words"),
    [
        (HostEngine.AUTO, {}, None),
        (HostEngine.SYSTEMD, {}, "not booted with systemd"),
        (HostEngine.SYSTEMD, {"systemd": "252"}, "no manager for user robot"),
        (HostEngine.AUTO, {"systemd": "252"}, None),
        (HostEngine.AUTO, {"systemd": "252", "manager": True}, "the last session"),
        (HostEngine.SSH, {"systemd": "252", "manager": True}, None),
        (HostEngine.AUTO, {"systemd": "252", "manager": True, "lingers": True}, None),
    ],
)
def test_systemd_must_keep_the_processes_of_the_user(
    engine: HostEngine, facts: Mapping[str, Any], words: str | None
):
    findings = check_member(member("bot", engine=engine, **facts))
    assert [words in finding.text for finding in findings] == ([] if words is None else [True])


@pytest.mark.parametrize(
    ("engine", "facts", "column"),
    [
        (HostEngine.SYSTEMD, {}, "no systemd"),
        (HostEngine.SYSTEMD, {"systemd": "252"}, "systemd 252"),
        (HostEngine.AUTO, {}, "ssh"),
    ],
)
def test_the_column_of_the_engine(engine: HostEngine, facts: Mapping[str, Any], column: str):
    one = member("bot", engine=engine, **facts)
    found = survey(member(LOCAL), one)

    text = as_text(Examination(survey=found, findings=(), mode=None))

    row = next(line for line in text.splitlines() if line.startswith("bot"))
    assert f"  {column}  " in row


@pytest.mark.parametrize(
    ("offset_s", "uncertainty_s", "level"),
    [
        (0.004, 0.001, None),
        (0.05, 0.2, None),  # it may be right
        (0.05, 0.001, Level.NOTE),
        (-0.05, 0.001, Level.NOTE),
        (5.0, 0.1, Level.PROBLEM),
    ],
)
def test_a_clock_counts_by_what_is_certain(
    offset_s: float, uncertainty_s: float, level: Level | None
):
    clock = Clock(offset_s=offset_s, uncertainty_s=uncertainty_s)
    findings = check_member(member("bot", clock=clock))
    assert [finding.level for finding in findings] == ([] if level is None else [level])


@pytest.mark.parametrize(
    ("settings", "is_wrong"),
    [
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, False),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}, True),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_STATIC_PEERS": "a"}, False),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF", "ROS_STATIC_PEERS": "a"}, True),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT", "ROS_STATIC_PEERS": "a"}, True),
        ({"ROS_LOCALHOST_ONLY": "1", "ROS_STATIC_PEERS": "a"}, True),
        ({"ROS_LOCALHOST_ONLY": "1", "ROS_DISCOVERY_SERVER": "a:1"}, False),
        ({"ROS_LOCALHOST_ONLY": ""}, False),
    ],
)
def test_settings_that_hide_other_hosts(settings: Mapping[str, str], is_wrong: bool):
    findings = check_member(member(LOCAL, settings=settings))
    assert [finding.check for finding in findings] == ["discovery"] * is_wrong


# ---- pairs


def test_hosts_that_agree_and_hear_each_other_are_fine():
    assert check_pairs(survey(member(LOCAL), member("bot1"), member("bot2")), None) == []


@pytest.mark.parametrize(
    ("changes", "check", "words"),
    [
        ({"settings": {"ROS_DOMAIN_ID": "3"}}, "domain", "0 on local and bot1, 3 on bot2"),
        ({"rclpy": "3.3.11"}, "distro", "jazzy on local and bot1, humble on bot2"),
        ({"middlewares": ["rmw_zenoh_cpp"]}, "middleware", "rmw_zenoh_cpp on bot2"),
        ({"rclpy": None}, "distro", "finds no ROS"),
    ],
)
def test_what_differs_is_told_with_its_values(changes: Mapping[str, Any], check: str, words: str):
    members = member(LOCAL), member("bot1"), member("bot2", **changes)
    finding = only(check_pairs(survey(*members), None))
    assert finding.check == check
    assert words in finding.text


@pytest.mark.parametrize(("protocol", "level"), [(1, Level.NOTE), (2, Level.PROBLEM)])
def test_another_launcher_is_a_problem_if_its_agent_is_not_understood(protocol: int, level: Level):
    other = member("bot1", version="9.9", protocol=protocol)
    finding = only(check_pairs(survey(member(LOCAL), other), None))
    assert (finding.check, finding.level) == ("launcher", level)
    assert finding.text.startswith(f"launcher 9.9 is installed, and {launcher.__version__} runs")


LOST_MULTICAST = (("multicast", "bot1", LOCAL), ("multicast", LOCAL, "bot1"))


@pytest.mark.parametrize(
    ("mode", "is_problem"),
    [(None, True), (DiscoveryMode.MULTICAST, True), (DiscoveryMode.PEERS, False)],
)
def test_multicast_matters_where_it_is_used(mode: DiscoveryMode | None, is_problem: bool):
    result = survey(member(LOCAL), member("bot1"), lost=LOST_MULTICAST)
    findings = check_pairs(result, mode)
    assert [one.text for one in findings if "bot1 <-> local" in one.text] == [
        finding.text for finding in findings
    ]
    assert len(findings) == is_problem


def test_multicast_does_not_matter_if_the_environment_names_peers():
    peers = {"ROS_STATIC_PEERS": "10.0.0.9"}
    members = [member(name, settings=peers) for name in (LOCAL, "bot1")]
    assert check_pairs(survey(*members, lost=LOST_MULTICAST), None) == []


def test_one_direction_is_told_as_such_and_not_again_for_multicast():
    lost = (("unicast", "bot1", LOCAL), ("multicast", "bot1", LOCAL))
    finding = only(check_pairs(survey(member(LOCAL), member("bot1"), lost=lost), None))
    assert "bot1 -> local" in finding.text
    assert finding.advice == "open UDP from port 7400 to 7649 in the firewalls"


def test_the_port_of_a_server_must_be_reached():
    ports = {"unicast": 7410, "multicast": 7400, "server": 11811}
    members = member(LOCAL), member("bot1", ports=ports)
    lost = (("server", LOCAL, "bot1"),)
    finding = only(check_pairs(survey(*members, lost=lost), DiscoveryMode.SERVER))
    assert "the port of the discovery server is not reached: local -> bot1" in finding.text


def twins(**changes: Any) -> Survey:
    same = {"addresses": ["10.0.0.7"], "boot_id": "x", **changes}
    return survey(member(LOCAL), member("bot1", **same), member("bot2", **same))


def test_one_address_with_one_shared_memory_is_one_machine():
    assert check_pairs(twins(), None) == []


def test_one_address_with_two_shared_memories_loses_messages():
    one = member("bot1", addresses=["10.0.0.7"], boot_id="x", shared_memory=1)
    other = member("bot2", addresses=["10.0.0.7"], boot_id="x", shared_memory=2)
    finding = only(check_pairs(survey(member(LOCAL), one, other), None))
    assert (finding.check, finding.hosts) == ("shared memory", ("bot1", "bot2"))


def test_containers_of_two_machines_may_have_the_same_address():
    """That of Docker's own bridge; numbers of devices are the same everywhere."""
    one = member("bot1", addresses=["172.17.0.2"], boot_id="x")
    other = member("bot2", addresses=["172.17.0.2"], boot_id="y")
    assert only(check_pairs(survey(member(LOCAL), one, other), None)).check == "shared memory"


def test_without_shared_memory_nothing_is_lost():
    udp = {"FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
    same = {"addresses": ["10.0.0.7"], "settings": udp}
    members = member(LOCAL), member("bot1", **same), member("bot2", **same)
    assert check_pairs(survey(*members), None) == []


def test_another_address_of_this_machine_there_is_noted():
    members = member(LOCAL, addresses=["10.0.0.1"]), member("bot1", client="192.168.1.1")
    finding = only(check_pairs(survey(*members), None))
    assert finding.level is Level.NOTE and "192.168.1.1" in finding.text
    members = member(LOCAL, addresses=["10.0.0.1"]), member("bot1", client="10.0.0.1")
    assert check_pairs(survey(*members), None) == []
