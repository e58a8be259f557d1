"""A run warns of nodes of others with names of its own, and never of its own nodes."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator

import pytest

from launcher.control.client import RefusedError
from tests.support.benches import ControlBench
from tests.support.children import children_with
from tests.support.controlled_run import ControlledRun
from tests.support.repository import REPOSITORY
from tests.support.ros_domain import ros_domain, talking
from tests.support.waiting import wait_until

pytestmark = pytest.mark.thorough

WARNING = "already has nodes with names of this run"
SLEEPER = 'sh("exec sleep 1000", name="sleeper"),'


@pytest.fixture
def bench(control_bench: ControlBench) -> Iterator[ControlBench]:
    with ros_domain(control_bench.folder / "ros_log") as env:
        for name in ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE"):
            control_bench.env[name] = env[name]
        yield control_bench


def node(**options: object) -> str:
    """The action that starts a node; without a name it is /logging_node."""
    given = "".join(f", {key}={value!r}" for key, value in options.items())
    return (
        "__import__('launch_ros').actions.Node(executable=sys.executable, output='log', "
        f"arguments=['-m', 'tests.support.logging_node'], cwd={str(REPOSITORY)!r}{given}),"
    )


def helpers(run: ControlledRun) -> list[int]:
    found = children_with(run.process.pid, "launcher.ros.helpers.namesakes")
    return [process.pid for process in found]


def wait_for_check(run: ControlledRun) -> None:
    """Wait until it has looked."""
    wait_until(lambda: helpers(run), "it looks")
    wait_until(lambda: not helpers(run), "it has looked")


def lines_of(run: ControlledRun) -> list[str]:
    return [line for line in run.screen.splitlines() if WARNING in line]


def wait_for_nodes(run: ControlledRun, count: int) -> None:
    """Wait until that many nodes have written something."""
    logged = "usual"
    wait_until(
        lambda: (
            len({one["process"] for one in run.ask("logs")["lines"] if logged in one["text"]})
            == count
        ),
        f"{count} nodes",
    )


def test_the_second_run_warns_once_with_the_names_and_the_first_run(bench: ControlBench):
    actions = node(name="talker", namespace="arm") + node(name="listener") + node()
    with bench.launch(actions) as first:
        wait_for_check(first)
        wait_for_nodes(first, 3)
        with bench.launch(actions + node(name="another")) as second:
            second.wait_for(WARNING)
            (line,) = lines_of(second)
            domain = bench.env["ROS_DOMAIN_ID"]
            expected = (
                rf"\[WARNING\] \[launch\]: ROS domain {domain} {WARNING}: "
                rf"/arm/talker, /listener(, /logging_node)? "
                rf"\(run {first.process.pid}-\w+, bench.launch.py\); "
                r"to keep the two apart, start one with ROS_DOMAIN_ID=(\d+), which is free, or "
                r"--private"
            )
            found = re.fullmatch(expected, line)
            assert found is not None, line
            assert found[2] != domain
            wait_until(lambda: not helpers(second), "it has looked")
            assert len(lines_of(second)) == 1
        assert lines_of(first) == []


def test_a_node_that_was_started_by_hand_is_named_with_its_pid(bench: ControlBench):
    with talking(bench.env, "tests.support.silent_node") as other:
        with bench.launch(node(name="silent")) as run:
            run.wait_for(f"{WARNING}: /silent (pid {other.pid}); ")
        with bench.launch(node(name="loud")) as run:
            wait_for_check(run)
            assert lines_of(run) == []


def test_a_younger_process_may_be_a_container_of_this_run(bench: ControlBench):
    """It is no descendant of the launcher, and does not have the run's id."""
    nodes = "".join(
        "__import__('launch_ros').actions.Node(executable=sys.executable, "
        f"arguments=['-c', 'import time; time.sleep(1000)']{more}),"
        for more in (", name='silent'", "")
    )
    with (
        talking(bench.env, "tests.support.bag_talker", "/bag/text"),
        # It looks as long as it can: the second process might have the name of the talker.
        bench.launch(nodes) as run,
    ):
        wait_until(lambda: helpers(run), "it looks")
        with talking(bench.env, "tests.support.silent_node"):
            assert helpers(run)
            wait_until(lambda: not helpers(run), "it has looked")
        assert lines_of(run) == []


@pytest.mark.parametrize("words", [(), ("--cold",)], ids=["warm", "cold"])
def test_own_nodes_are_never_reported_also_when_they_are_restarted(
    bench: ControlBench, words: tuple[str, ...]
):
    actions = node(name="talker") + node() + node(name="again", respawn=True)
    with (
        talking(bench.env, "tests.support.silent_node"),  # so that it looks longer
        bench.launch(actions, *words) as run,
    ):
        wait_until(lambda: helpers(run), "it looks")
        while helpers(run):
            run.ask("restart", "/talker")
            with contextlib.suppress(RefusedError):  # it is just being restarted
                run.ask("kill", "/again")
        assert lines_of(run) == []
        run.ask("quit")
        assert run.exit_code() == 0


@pytest.mark.parametrize(
    ("actions", "words"),
    [
        ("", ()),
        (node(name="talker"), ("--no-domain-check",)),
        (node(name="talker"), ("--private",)),
    ],
    ids=["no node", "by option", "private"],
)
def test_nothing_looks_where_there_is_no_need(
    bench: ControlBench, actions: str, words: tuple[str, ...]
):
    with bench.launch(SLEEPER + actions, *words) as run:

        def is_old() -> bool:
            assert helpers(run) == []
            return run.row("sleeper")["uptime_s"] > 2

        wait_until(is_old, "a while")
