"""The discovery range, and hints for an empty domain."""

from __future__ import annotations

import pytest

from launcher.posix.domains import is_off, localhost_only, why_empty


@pytest.mark.parametrize(
    ("environment", "off", "local"),
    [
        ({}, False, False),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": ""}, False, False),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, False, False),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT"}, False, False),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}, False, True),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}, True, True),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "off"}, False, True),  # rcl warns and takes LOCALHOST
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF", "ROS_LOCALHOST_ONLY": "1"}, False, True),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_STATIC_PEERS": "a"}, False, False),
        ({"ROS_LOCALHOST_ONLY": "1", "ROS_STATIC_PEERS": "a"}, False, True),
        ({"ROS_LOCALHOST_ONLY": "1", "ROS_DISCOVERY_SERVER": "a:1"}, False, False),
    ],
    ids=str,
)
def test_how_far_discovery_goes_is_read_as_rcl_does(environment, off, local):
    assert (is_off(environment), localhost_only(environment)) == (off, local)


def test_where_discovery_is_off_no_other_domain_is_recommended(monkeypatch):
    monkeypatch.delenv("ROS_LOCALHOST_ONLY", raising=False)
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    assert why_empty(7) == (
        "0 nodes on domain 7: discovery is off (ROS_AUTOMATIC_DISCOVERY_RANGE=OFF); "
        "unset it, or set it to LOCALHOST or SUBNET"
    )


@pytest.mark.parametrize(("others", "end"), [({9}, "domain 9 is active"), ({9, 11}, "are active")])
def test_the_hint_at_another_domain_has_an_option_of_all_verbs(monkeypatch, others, end):
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    used = dict.fromkeys(others, 1)
    monkeypatch.setattr("launcher.posix.domains.participants_by_domain", lambda: used)
    assert why_empty(7).endswith(f"{end}: add --domain 9")
