"""Settings of the environment with which ROS verbs cannot look at the graph."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.base.errors import UsageError
from launcher.cli import dispatch as cli
from launcher.posix.domains import OFF
from launcher.ros.discovery.environment_check import check_environment

INDEX = "share/ament_index/resource_index/rmw_typesupport"


@pytest.mark.parametrize(
    ("environment", "message", "hint"),
    [
        (
            {"RMW_IMPLEMENTATION": "rmw_bogus"},
            "RMW_IMPLEMENTATION is 'rmw_bogus', a middleware that is not installed",
            "unset it, or set it to rmw_fastrtps_cpp",
        ),
        (
            {"RMW_IMPLEMENTATION": "rmw_fastrtps_ccp"},
            "RMW_IMPLEMENTATION is 'rmw_fastrtps_ccp', a middleware that is not installed",
            "did you mean 'rmw_fastrtps_cpp'?",
        ),
        (
            {"RCL_ASSERT_RMW_ID_MATCHES": "rmw_bogus"},
            "RCL_ASSERT_RMW_ID_MATCHES is 'rmw_bogus', a middleware that is not installed",
            "unset it, or set it to rmw_fastrtps_cpp",
        ),
        (
            {"ROS_AUTOMATIC_DISCOVERY_RANGE": "BOGUS"},
            "ROS_AUTOMATIC_DISCOVERY_RANGE is 'BOGUS'",
            "one of OFF, LOCALHOST, SUBNET, SYSTEM_DEFAULT",
        ),
        (
            {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCLHOST"},
            "ROS_AUTOMATIC_DISCOVERY_RANGE is 'LOCLHOST'",
            "did you mean 'LOCALHOST'?",
        ),
    ],
    ids=["rmw", "near", "assertion", "range", "near-range"],
)
def test_what_rcl_refuses_or_mistakes_is_named(environment, message, hint):
    with pytest.raises(UsageError) as raised:
        check_environment(environment)
    assert (raised.value.message, raised.value.hint) == (message, hint)


@pytest.mark.parametrize(
    "environment",
    [
        {},
        {"RMW_IMPLEMENTATION": "", "ROS_AUTOMATIC_DISCOVERY_RANGE": ""},
        {"RMW_IMPLEMENTATION": "rmw_fastrtps_cpp", "ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"},
        {"ROS_AUTOMATIC_DISCOVERY_RANGE": "BOGUS", "ROS_LOCALHOST_ONLY": "1"},
    ],
)
def test_what_rcl_takes(environment):
    check_environment(environment)


def test_a_middleware_of_a_workspace_is_installed(tmp_path: Path):
    (tmp_path / INDEX).mkdir(parents=True)
    (tmp_path / INDEX / "rmw_own_cpp").touch()
    check_environment({"RMW_IMPLEMENTATION": "rmw_own_cpp", "AMENT_PREFIX_PATH": str(tmp_path)})


@pytest.mark.parametrize("verb", ["topic list", "topic echo /t", "node ps", "param list", "graph"])
def test_verbs_say_it_in_one_sentence(verb, monkeypatch, capsys):
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_bogus")
    assert cli.main(verb.split()) == 2
    assert capsys.readouterr().err.startswith("error: RMW_IMPLEMENTATION is 'rmw_bogus', ")


@pytest.mark.parametrize(
    ("verb", "more"),
    [
        ("node list", ""),
        ("param get /n p", "Node not found\n"),
        ("service call /s std_srvs/srv/Trigger", "service '/s' is not available after 0.1 s\n"),
    ],
)
def test_discovery_that_is_off_is_reported_once_by_every_verb(verb, more, monkeypatch, capsys):
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    monkeypatch.setenv("ROS_DOMAIN_ID", "")  # counts as 0
    limit = ["--timeout", "0.1"] if more else []
    cli.main([*verb.split(), *limit, "--spin-time", "0.1", "--no-observer"])
    assert capsys.readouterr().err == f"{OFF}\n{more}"


def test_interface_needs_no_middleware(monkeypatch, capsys):
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_bogus")
    assert cli.main(["interface", "show", "std_msgs/msg/Empty"]) == 0
