"""What helper processes know of nodes that restart again and again."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from rclpy.qos import QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Empty

from launcher.bag.ros import recorder as recorder_module
from launcher.bag.ros.recorder import Recorder, RecorderOptions
from launcher.bag.ros.sinks import Ring
from launcher.bag.topic_selection import Selection
from launcher.ros.discovery.follower import DiscoveryFollower
from launcher.ros.discovery.observer import Observer
from launcher.ros.probe.probe_snapshot import GraphWatcher
from tests.support.domain import Domain, private_domain
from tests.support.waiting import wait_until


@pytest.fixture
def domain(tmp_path: Path) -> Iterator[Domain]:
    with private_domain(tmp_path) as domain:
        yield domain


@pytest.fixture
def observer(domain: Domain) -> Iterator[Observer]:
    with Observer(int(domain.env["ROS_DOMAIN_ID"])) as observer:
        yield observer


def test_a_recorder_forgets_publishers_that_have_gone(domain: Domain, observer, monkeypatch):
    monkeypatch.setattr(recorder_module, "_REFIT_S", 0.0)
    options = RecorderOptions(selection=Selection(topics=("/often",)), remember_s=0.0)
    recorder = Recorder(observer, options, Ring(1_000_000), lambda text: None)

    def polls_until(fact, what):
        wait_until(lambda: (recorder.poll(), fact())[1], what)

    for number in range(20):
        publisher = domain.listener.create_publisher(String, "/often", QoSProfile(depth=5))

        def arrives(publisher=publisher, number=number) -> bool:
            publisher.publish(String(data=str(number)))
            return recorder.topics["/often"].fitted.numbers.last.keys() & recorder.nodes.keys()

        polls_until(lambda: "/often" in recorder.topics, "the topic is recorded")
        polls_until(arrives, "a message")
        domain.listener.destroy_publisher(publisher)
        polls_until(lambda: not recorder.topics["/often"].publishers, "it has gone")
    recorded = recorder.topics["/often"]
    assert recorded.count >= 20
    last = recorded.fitted.numbers.last
    polls_until(lambda: not recorder.nodes and not last, "all are forgotten")
    assert len(recorded.topic.qos) == 1
    recorder.close()


def test_a_node_forgets_what_it_has_destroyed(observer):
    node = observer.node
    kept = [node.create_client(Empty, f"kept_{number}") for number in range(10)]
    for _ in range(1000):
        node.destroy_client(node.create_client(Empty, "often"))
    group = node.default_callback_group
    assert len(group.entities) < 300
    assert all(group.has_entity(client) for client in kept)


def test_a_probe_forgets_processes_that_have_ended(domain: Domain, observer):
    watcher = GraphWatcher(observer)
    node = domain.start("robot_1")
    wait_until(lambda: watcher.take().pids.get("/robot_1") == node.pid, "it is found")
    node.stop()
    wait_until(lambda: not watcher.take().pids.get("/robot_1"), "it has gone")
    assert node.pid not in watcher._pids.values()
    watcher.close()


def test_who_follows_discovery_messages_forgets_participants_that_have_ended(domain: Domain):
    def nodes() -> set[str]:
        follower.poll()
        return {node.name for peer in follower.participants for node in peer.nodes()}

    domain_id = int(domain.env["ROS_DOMAIN_ID"])
    with DiscoveryFollower(domain_id, remote=False) as follower:
        node = domain.start("robot_1")
        wait_until(lambda: {"/robot_1", "/listener"} <= nodes(), "both are there")
        node.stop()
        wait_until(lambda: "/robot_1" not in nodes(), "one has ended")
        assert len(follower.discovered) == len(follower.participants) == 1
        kept = (follower.since, follower._inodes, follower._subscribed)
        assert {len(one) for one in kept} == {1}


@pytest.mark.thorough
@pytest.mark.parametrize("ways", ["probe", "graph", "snapshot"])
def test_a_node_that_rmw_lists_after_its_end_is_not_shown(
    domain: Domain, observer, ways, monkeypatch
):
    """rmw does so if it takes the last but one list of nodes of a participant too late."""
    watcher = GraphWatcher(observer)
    listed = {
        "probe": lambda: watcher.take().snapshot.nodes,
        "graph": lambda: observer.topic_graph().nodes,
        "snapshot": lambda: observer.graph_snapshot().nodes,
    }[ways]
    node = domain.start("robot_1")
    wait_until(lambda: "/robot_1" in listed(), "it is there")
    wait_until(lambda: "/robot_1" in {e.node for e in observer.all_endpoints()}, "with endpoints")
    assert "/robot_1" in listed()
    node.stop()
    node_names = observer.node_names

    is_kept: bool | None = None  # by rmw itself: then this test must not list it once more

    def with_ended_node() -> list[str]:
        names = node_names()
        has_it = "/robot_1" in names if is_kept is None else is_kept
        return names if has_it else sorted([*names, "/robot_1"])

    monkeypatch.setattr(observer, "node_names", with_ended_node)
    wait_until(lambda: "/robot_1" not in listed(), "it is not shown any more")
    is_kept = "/robot_1" in node_names()
    again = domain.start("robot_1")
    wait_until(lambda: listed().count("/robot_1") == 1, "one of its name is there again")
    wait_until(lambda: watcher.take().pids.get("/robot_1") == again.pid, "with its process")
    assert listed().count("/robot_1") == 1
    watcher.close()
