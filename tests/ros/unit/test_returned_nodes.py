"""Which node an endpoint belongs to whose participant was out of reach for a while."""

from __future__ import annotations

from launcher.ros.discovery.returned_nodes import ReturnedNodes
from launcher.ros.snapshot.ros_graph import UNKNOWN_NODE, Endpoint


def endpoint(number: int, node: str = UNKNOWN_NODE, participant: int = 1) -> Endpoint:
    gid = ".".join([f"{participant:02x}"] * 12 + [f"{number:02x}"] * 4)
    qos = {"reliability": "RELIABLE", "durability": "VOLATILE"}
    return Endpoint(topic="/a", node=node, direction="publisher", type="a/msg/A", gid=gid, **qos)


def test_an_endpoint_that_comes_back_without_a_name_has_that_of_before():
    nodes = ReturnedNodes()
    nodes.named([endpoint(1, "/x"), endpoint(2, "/y")])
    assert nodes.names == frozenset()
    assert nodes.named([]) == []
    assert nodes.named([endpoint(1), endpoint(2)]) == [endpoint(1, "/x"), endpoint(2, "/y")]
    assert nodes.names == {"/x", "/y"}


def test_an_endpoint_that_never_had_a_name_has_none():
    nodes = ReturnedNodes()
    nodes.named([endpoint(1, "/x")])
    assert nodes.named([endpoint(1), endpoint(3)]) == [endpoint(1, "/x")]


def test_a_node_that_has_left_a_participant_with_others_is_gone():
    nodes = ReturnedNodes()
    nodes.named([endpoint(1, "/x"), endpoint(2, "/y")])
    assert nodes.named([endpoint(1), endpoint(2, "/y")]) == [endpoint(2, "/y")]
    assert nodes.names == frozenset()
