"""The prefetch reads the graph while rclpy is being loaded, and introduces our participant."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Iterator

import pytest

from launcher.ros.discovery.discovery_reader import read_graph
from launcher.ros.discovery.observer import Observer
from launcher.ros.discovery.prefetch import Prefetch
from tests.ros.ros.test_discovery_reader import threads_stand_still
from tests.support.ros_domain import ros_domain, talking
from tests.support.verbs import launcher
from tests.support.waiting import wait_until

pytestmark = pytest.mark.thorough

TIMEOUT_S = 30.0


@contextlib.contextmanager
def prefetching(
    domain_id: int, *, remote: bool = False, listens: bool = False
) -> Iterator[Prefetch]:
    with contextlib.closing(
        Prefetch(domain_id, TIMEOUT_S, remote=remote, listens=listens)
    ) as prefetch:
        yield prefetch


@pytest.mark.parametrize("remote", [False, True], ids=["localhost", "subnet"])
def test_the_prefetch_equals_a_snapshot_without_our_own_participant(tmp_path, remote):
    with ros_domain(tmp_path) as env, talking(env, "tests.support.sample_nodes"):
        domain_id = int(env["ROS_DOMAIN_ID"])
        alone = read_graph(domain_id, TIMEOUT_S, remote=remote).snapshot
        with (
            prefetching(domain_id, remote=remote) as prefetch,
            Observer(domain_id, prefetch=prefetch) as observer,
        ):
            assert observer.prefetched_graph() == alone
            wait_until(lambda: observer.graph_snapshot() == alone, "rclpy has seen all as well")


def test_prefetched_data_is_used_if_no_participant_answers_later(tmp_path):
    with ros_domain(tmp_path) as env, talking(env, "tests.support.sample_nodes") as program:
        domain_id = int(env["ROS_DOMAIN_ID"])
        with prefetching(domain_id, listens=True) as prefetch:
            assert prefetch.snapshot(b"") is not None
            os.kill(program.pid, signal.SIGSTOP)
            try:
                wait_until(lambda: threads_stand_still(program.pid), "it cannot answer")
                with Observer(domain_id, prefetch=prefetch) as observer:
                    wait_until(
                        lambda: {"/chatter", "/weak"} <= observer.topic_types().keys(),
                        "its topics are known",
                    )
            finally:
                os.kill(program.pid, signal.SIGCONT)


def test_closing_the_prefetch_ends_a_pending_snapshot(tmp_path):
    with ros_domain(tmp_path) as env, talking(env, "tests.support.sample_nodes") as program:
        os.kill(program.pid, signal.SIGSTOP)
        try:
            wait_until(lambda: threads_stand_still(program.pid), "it cannot answer")
            with contextlib.closing(Prefetch(int(env["ROS_DOMAIN_ID"]), 3600.0, remote=False)):
                pass
        finally:
            os.kill(program.pid, signal.SIGCONT)


def test_verbs_find_their_node_although_another_does_not_answer(tmp_path):
    """The silent one is no reason to wait for the longest time."""
    with (
        ros_domain(tmp_path) as env,
        talking(env, "tests.support.sample_nodes"),
        talking(env, "tests.support.number_publisher", "silent", "1", "1") as silent,
    ):
        os.kill(silent.pid, signal.SIGSTOP)
        try:
            wait_until(lambda: threads_stand_still(silent.pid), "it cannot answer")
            words = ("--spin-time", "3600")
            echo = launcher(env, "topic", "echo", "/chatter", "--once", *words)
            assert "data: msg " in echo.out
            speed = launcher(env, "param", "get", "/talker", "speed", *words)
            # Fast DDS may complain first: of a port that somebody just gives up
            assert speed.lines[-1] == "Double value is: 1.5"
            switch = launcher(
                env, "service", "call", "/switch", "std_srvs/SetBool", "{data: true}", *words
            )
            assert "success=True, message='on'" in switch.out
        finally:
            os.kill(silent.pid, signal.SIGCONT)


def test_ctrl_c_may_come_while_our_participant_is_about_to_be_introduced(tmp_path, monkeypatch):
    with ros_domain(tmp_path) as env, prefetching(int(env["ROS_DOMAIN_ID"])) as prefetch:

        def interrupted(thread: threading.Thread) -> None:
            raise KeyboardInterrupt

        monkeypatch.setattr(threading.Thread, "start", interrupted)
        with pytest.raises(KeyboardInterrupt):
            prefetch.introduce()
        prefetch.close()
