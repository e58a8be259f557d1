"""The verbs of docs/guides/fleet.md on the running fleet."""

from __future__ import annotations

import contextlib
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping

import pytest

from launcher.base.errors import ExitCode
from tests.support.domain import private_domain
from tests.support.repository import docs_page
from tests.support.ros_domain import ros_domain
from tests.support.verbs import TIMEOUT_S, Answer, eventually, launcher
from tests.support.waiting import wait_until

PAGE = docs_page("ros-verbs")


@pytest.mark.thorough
def test_the_probe_that_hears_nothing_is_explained(tmp_path):
    with private_domain(tmp_path) as domain:
        domain.start("robot_1")
        domain.start("qos_probe")
        domain.wait_for_nodes("robot_1", "qos_probe")
        answer = eventually(
            lambda: launcher(domain.env, "topic", "info", "/fleet/status", "-v"),
            # both ends have their names; discovery may have had to end without
            lambda answer: "/qos_probe receives nothing from /robot_1\n" in answer.out,
        )
        assert "  Reliability: BEST_EFFORT\n" in answer.out
        assert answer.out.endswith(
            "QoS: 1 of 1 pair of publisher and subscription does not match\n"
            "  /qos_probe receives nothing from /robot_1\n"
            "    RELIABILITY: the publisher offers BEST_EFFORT, "
            "the subscription asks for RELIABLE\n"
            "    to repair: set the subscription's reliability to BEST_EFFORT, "
            "or the publisher's to RELIABLE\n"
        )
        processes = eventually(
            lambda: launcher(domain.env, "node", "ps", "--json"),
            lambda answer: {"/robot_1", "/qos_probe"} <= pids_in(answer).keys(),
        )
        pids = pids_in(processes)
        assert pids["/robot_1"] == domain.nodes[0].pid
        assert pids["/qos_probe"] == domain.nodes[1].pid


def pids_in(answer: Answer) -> dict[str, int | None]:
    """The pid of each node in `node ps --json`."""
    return {row["name"]: row["pid"] for row in answer.json()["nodes"]}


@pytest.mark.thorough
def test_the_verbs_work_on_a_running_system_as_documented(tmp_path):
    with ros_domain(tmp_path) as env, launched("system", "--no-control", env=env):
        wait_until(
            lambda: (
                launcher(env, "node", "list").lines
                == ["/dispatcher", "/monitor", "/robot_1", "/robot_2", "/robot_3"]
            ),
            "all nodes are up",
        )
        # A node is there before its topics.
        wanted = {"/fleet/report", "/fleet/status", "/fleet/tasks"}
        wait_until(lambda: wanted <= topics_of(env), "all topics are there")
        wait_until(
            lambda: "Publisher count: 3" in launcher(env, "topic", "info", "/fleet/status").lines,
            "every robot publishes",
        )
        hz = ("topic", "hz", "/fleet/status", "--for", "4", "--min", "1")
        eventually(lambda: launcher(env, *hz), lambda rate: rate.code == 0)
        graph = ("graph", "--mode", "active")
        eventually(lambda: launcher(env, *graph), lambda tree: "/fleet/tasks" in tree.out)
        assert launcher(env, *documented("topic pub")).code == 0


def documented(verb: str) -> list[str]:
    """The example of a verb in docs/reference/ros-verbs.md."""
    pattern = rf"^python -m launcher ({verb} .*)$"
    found = re.search(pattern, PAGE, re.M)
    assert found is not None
    return shlex.split(found[1])


def topics_of(env: Mapping[str, str]) -> set[str]:
    return {line.split()[0] for line in launcher(env, "topic", "list", "-t").lines}


@contextlib.contextmanager
def launched(*words: str, env: Mapping[str, str]) -> Iterator[subprocess.Popen[bytes]]:
    """A system that runs; Ctrl-C in the end."""
    program = subprocess.Popen(
        [sys.executable, "-m", "launcher", *words],
        env=dict(env),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
    )
    try:
        yield program
    finally:
        program.send_signal(signal.SIGINT)
        # a robot of the scenario may have died by then
        assert program.wait(TIMEOUT_S) in (ExitCode.OK, ExitCode.INTERRUPTED)
