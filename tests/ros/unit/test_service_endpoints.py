"""Which reader and writer of DDS make a client or a server, and how `service info -v` prints it."""

from __future__ import annotations

import pytest

from launcher.ros.service_endpoints import endpoints, info_lines
from launcher.ros.snapshot.ros_graph import Direction, EndpointInfo, GraphSnapshot

TYPE = "std_srvs::srv::dds_::SetBool_{}_"
A, B = "01." * 11 + "0a", "01." * 11 + "0b"  # two participants


def info(topic: str, node: str, direction: Direction, gid: str, part: str) -> EndpointInfo:
    return EndpointInfo(
        topic=topic,
        node=node,
        direction=direction.value,
        type=TYPE.format(part),
        reliability="RELIABLE",
        durability="VOLATILE",
        gid=gid,
    )


def client(node: str, participant: str, number: int) -> list[EndpointInfo]:
    read, write = (f"{participant}.00.00.{one:02x}.04" for one in (number, number + 1))
    return [
        info("rr/switchReply", node, Direction.SUBSCRIPTION, read, "Response"),
        info("rq/switchRequest", node, Direction.PUBLISHER, write, "Request"),
    ]


def server(node: str, participant: str, number: int) -> list[EndpointInfo]:
    read, write = (f"{participant}.00.00.{one:02x}.03" for one in (number, number + 1))
    return [
        info("rq/switchRequest", node, Direction.SUBSCRIPTION, read, "Request"),
        info("rr/switchReply", node, Direction.PUBLISHER, write, "Response"),
    ]


def graph(*infos: EndpointInfo) -> GraphSnapshot:
    return GraphSnapshot(domain_id=0, nodes=("/a", "/b"), infos=infos)


def test_each_reader_gets_the_writer_that_its_node_made_with_it():
    found = endpoints(
        graph(*client("/a", A, 5), *client("/a", A, 3), *client("/b", B, 3), *server("/b", B, 7)),
        "/switch",
    )
    assert [(one.reader.node, one.is_client) for one in found] == [
        ("/a", True),
        ("/a", True),
        ("/b", True),
        ("/b", False),
    ]
    for one in found:
        assert one.writer is not None
        first, second = (int(e.gid.split(".")[-2], 16) for e in (one.reader, one.writer))
        assert (second - first, one.writer.node) == (1, one.reader.node)


@pytest.mark.parametrize(
    ("made", "head", "titles"),
    [
        (client, "Endpoint type: CLIENT", ["Request Writer", "Response Reader"]),
        (server, "Endpoint type: SERVER", ["Request Reader", "Response Writer"]),
    ],
)
def test_the_lines_of_a_client_and_of_a_server(made, head, titles):
    (one,) = endpoints(graph(*made("/ns/a", A, 3)), "/switch")
    lines = list(one.lines())
    assert lines[:3] == [
        "Node name: a",
        "Node namespace: /ns",
        "Service type: std_srvs/srv/SetBool",
    ]
    assert lines[4:7] == [head, "Endpoint count: 2", "GIDs:"]
    assert [line.rpartition(" : ")[0] for line in lines[7:9]] == [f" - {one}" for one in titles]
    assert lines[9:12] == ["QoS profiles:", f" - {titles[0]} :", "      Reliability: RELIABLE"]
    assert lines[18:20] == [f" - {titles[1]} :", "      Reliability: RELIABLE"]


def test_without_its_writer_an_endpoint_has_one_gid():
    reader, _ = server("/a", A, 3)
    (one,) = endpoints(graph(reader), "/switch")
    lines = list(one.lines())
    assert lines[5:9] == [
        "Endpoint count: 1",
        f"GID: {reader.gid}",
        "QoS profile:",
        "  Reliability: RELIABLE",
    ]
    assert one.document().keys() == {"node", "role", "type_hash", "request_reader"}


def test_the_type_hash_of_another_definition_is_not_known():
    (one,) = endpoints(graph(*server("/a", A, 3)), "/switch")
    assert one.type_hash() == "INVALID"


def test_counts_stand_before_the_blocks():
    found = endpoints(graph(*client("/a", A, 3), *server("/b", B, 3)), "/switch")
    lines = list(info_lines(found, ["std_srvs/srv/SetBool"], verbose=True))
    assert lines[:3] == ["Type: std_srvs/srv/SetBool", "Clients count: 1", "Node name: a"]
    assert lines[lines.index("Services count: 1") - 1] == ""
    assert lines[-1] == ""
