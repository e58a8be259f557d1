"""Snapshots by the discovery reader equal those by rclpy."""

from __future__ import annotations

import os
import signal

import psutil
import pytest
from std_msgs.msg import String

from launcher.posix.ports import participants_by_domain
from launcher.ros.discovery.discovery_reader import read_graph
from launcher.ros.discovery.observer import Observer
from launcher.ros.discovery.rtps import UNKNOWN_VENDOR
from tests.support.ros_domain import ros_domain, talking
from tests.support.verbs import eventually, launcher
from tests.support.waiting import wait_until

TIMEOUT_S = 60.0


def by_reader(domain_id: int, *, remote: bool = False):
    seen = read_graph(domain_id, TIMEOUT_S, remote=remote)
    assert seen.missing == 0
    return seen.snapshot


@pytest.mark.parametrize(
    "remote",
    [
        pytest.param(False, id="localhost"),
        pytest.param(True, id="subnet", marks=pytest.mark.thorough),
    ],
)
def test_both_ways_see_the_same_in_every_detail(tmp_path, remote):
    with ros_domain(tmp_path) as env, talking(env, "tests.support.sample_nodes"):
        domain_id = int(env["ROS_DOMAIN_ID"])
        ours = by_reader(domain_id, remote=remote)
        with Observer(domain_id) as observer:
            wait_until(lambda: observer.graph_snapshot() == ours, "rclpy has seen all")
        assert len(ours.infos) > 50
        assert "/switch" in ours.service_types()


def test_a_reader_is_forgotten_at_once(env, observer, monkeypatch):
    monkeypatch.setattr(
        "launcher.ros.discovery.discovery_reader._LEASE_S", 3600
    )  # so it says that it leaves

    def gids() -> list[bytes]:
        infos = observer.node.get_subscriptions_info_by_topic("ros_discovery_info", no_mangle=True)
        return [bytes(info.endpoint_gid) for info in infos]

    by_reader(int(env["ROS_DOMAIN_ID"]))
    # A GID begins with the vendor of the DDS stack; only the reader's is unknown.
    wait_until(
        lambda: not any(gid.startswith(UNKNOWN_VENDOR) for gid in gids()), "the reader is unknown"
    )
    assert gids()


@pytest.mark.thorough
def test_many_concurrent_snapshots_are_all_complete(env):
    from concurrent.futures import ThreadPoolExecutor

    domain_id = int(env["ROS_DOMAIN_ID"])
    with ThreadPoolExecutor(5) as pool:
        looks = list(pool.map(by_reader, [domain_id] * 10))
    assert {look.nodes for look in looks} == {looks[0].nodes}
    assert looks[0].nodes.count("/twin") == 2


@pytest.mark.thorough
def test_more_endpoints_than_one_request_can_name(empty_domain):
    domain_id = int(empty_domain["ROS_DOMAIN_ID"])
    with Observer(domain_id, name="busy") as busy:
        topics = {f"/t{number}" for number in range(600)}
        publishers = [busy.node.create_publisher(String, topic, 1) for topic in topics]
        look = by_reader(domain_id)
        assert topics <= look.topic_types().keys()
        assert look.nodes == ("/busy",)
        assert len(publishers) == 600


def threads_stand_still(pid: int) -> bool:
    """Whether each has noticed the SIGSTOP; one that has not may still answer."""
    threads = [psutil.Process(thread.id) for thread in psutil.Process(pid).threads()]
    return all(thread.status() == psutil.STATUS_STOPPED for thread in threads)


def test_a_participant_that_cannot_answer_is_reported(tmp_path):
    with ros_domain(tmp_path) as env, talking(env, "tests.support.sample_nodes") as program:
        os.kill(program.pid, signal.SIGSTOP)
        wait_until(lambda: threads_stand_still(program.pid), "no thread can answer any more")
        try:
            seen = read_graph(int(env["ROS_DOMAIN_ID"]), 0.5, remote=False)
        finally:
            os.kill(program.pid, signal.SIGCONT)
        assert (seen.missing, seen.snapshot.nodes) == (1, ())
        assert "/talker" in by_reader(int(env["ROS_DOMAIN_ID"])).nodes


@pytest.mark.thorough
def test_verbs_give_the_same_result_with_unusual_discovery_settings(env):
    words = ("topic", "list", "-t")
    plain = eventually(lambda: launcher(env, *words), lambda answer: "/weak" in answer.out)
    abroad = {**env, "ROS_STATIC_PEERS": "127.0.0.1"}
    unusual = eventually(lambda: launcher(abroad, *words), lambda answer: answer.out == plain.out)
    assert plain.code == unusual.code


def test_a_domain_without_anybody_is_known_to_be_empty(empty_domain):
    domain_id = int(empty_domain["ROS_DOMAIN_ID"])
    assert participants_by_domain()[domain_id] == 0
    assert by_reader(domain_id).infos == ()
