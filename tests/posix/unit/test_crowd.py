"""How many nodes on one machine find each other, and what is said about more."""

from __future__ import annotations

import pytest

from launcher.hosts.discovery import PROFILES, RANGE, SERVERS, Wiring
from launcher.hosts.file.hosts_model import DiscoveryMode
from launcher.posix.crowd import DOMAIN_MAX, LOCALHOST_MAX, limit, too_many

LOCALHOST = {RANGE: "LOCALHOST", "ROS_DOMAIN_ID": "7"}
SUBNET = {RANGE: "SUBNET", "ROS_DOMAIN_ID": "7"}


@pytest.mark.parametrize(
    ("environment", "expected"),
    [
        ({}, DOMAIN_MAX),
        ({RANGE: ""}, DOMAIN_MAX),
        ({RANGE: "SYSTEM_DEFAULT"}, DOMAIN_MAX),
        ({RANGE: "LOCALHOST"}, LOCALHOST_MAX),
        ({RANGE: "nonsense"}, LOCALHOST_MAX),
        ({"ROS_LOCALHOST_ONLY": "1"}, LOCALHOST_MAX),
        ({RANGE: "OFF"}, None),
        ({RANGE: "LOCALHOST", SERVERS: "127.0.0.1:11811"}, DOMAIN_MAX),
        ({RANGE: "LOCALHOST", PROFILES: "/mine.xml"}, None),
        ({RANGE: "LOCALHOST", "RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}, None),
        ({RANGE: "LOCALHOST", "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp"}, LOCALHOST_MAX),
    ],
)
def test_the_limit_follows_from_the_environment(environment, expected):
    assert limit(environment) == expected


def test_as_many_as_find_each_other_are_no_crowd():
    assert too_many([LOCALHOST] * 33, {}) == []
    assert too_many([SUBNET] * 101, {}) == []
    assert too_many([LOCALHOST] * 33, {8: 50}) == []  # another domain
    assert too_many([], {7: 200}) == []


def test_one_more_is_and_the_message_has_the_repair():
    assert too_many([LOCALHOST] * 34, {}) == [
        "34 nodes on domain 7 do not all find each other: with "
        "ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST, 33 do; use --discovery server, or "
        "ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET"
    ]
    assert too_many([SUBNET] * 102, {}) == [
        "102 nodes on domain 7: Fast DDS has ports for 101 processes of a domain on one machine, "
        "and the others find no node; use --discovery server"
    ]


def test_what_runs_already_counts_too():
    (message,) = too_many([LOCALHOST] * 30, {7: 4})
    assert message.startswith("30 nodes on domain 7, besides 4 that run already, do not all find")


def test_a_range_that_is_too_small_as_well_is_no_repair():
    (message,) = too_many([LOCALHOST] * 110, {})
    assert message.endswith("33 do; use --discovery server")


def test_a_server_of_the_user_has_no_ports_either():
    (message,) = too_many([{**SUBNET, SERVERS: "10.0.0.1:11811"}] * 102, {})
    assert message.endswith("let the launcher start the server, with --discovery server")


def test_each_domain_counts_by_itself():
    other = {**LOCALHOST, "ROS_DOMAIN_ID": "8"}
    messages = too_many([LOCALHOST] * 34 + [other] * 35, {})
    assert [message[:20] for message in messages] == [
        "34 nodes on domain 7",
        "35 nodes on domain 8",
    ]


def test_a_server_of_the_run_has_ports_for_all_unless_users_have_profiles(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    wiring = Wiring(mode=DiscoveryMode.SERVER)
    (path,) = wiring.profile({}).values()
    assert path.endswith("many_participants.xml") and limit({PROFILES: path}) is None
    assert wiring.profile({PROFILES: "/mine.xml"}) == {}
    assert wiring.profile({"FASTDDS_DEFAULT_PROFILES_FILE": "/mine.xml"}) == {}
    assert Wiring(mode=DiscoveryMode.PEERS).profile({}) == {}
    (tmp_path / "DEFAULT_FASTRTPS_PROFILES.xml").write_text("<dds/>")
    assert wiring.profile({}) == {}
