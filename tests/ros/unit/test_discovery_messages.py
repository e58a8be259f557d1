"""Discovery messages: encoding, decoding, and malformed datagrams."""

from __future__ import annotations

import contextlib
import os
import socket
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from launcher.base.model.record import replace
from launcher.posix.domains import is_plain
from launcher.posix.ports import multicast_port, occupied_ports
from launcher.ros.discovery import rtps
from launcher.ros.discovery.endpoints import contact_in, endpoint_in, nodes_in
from launcher.ros.discovery.gids import widen_sockets
from launcher.ros.discovery.participant import Participant, SampleStream, snapshot_of
from launcher.ros.snapshot.ros_graph import (
    Direction,
    EndpointInfo,
    GraphSnapshot,
    from_document,
    ros_name,
    ros_type,
)

OWN, OTHER = b"\1\2" + b"a" * 10, b"\3\4" + b"b" * 10
VENDOR = b"\0\0"
PEER = b"\1\x0f" + b"p" * 10
TALKER_GID = PEER + bytes.fromhex("00001103")
INFO_WRITER = bytes.fromhex("00000103")


def received(*submessages: bytes) -> list[rtps.Part]:
    return list(rtps.parts(rtps.message(PEER, VENDOR, *submessages), OWN))


def publication(topic: str, gid: bytes = TALKER_GID, kind: str = "std_msgs::msg::dds_::String_"):
    listed = [(0x5A, gid), (0x05, rtps.text(topic)), (0x07, rtps.text(kind))]
    return rtps.sample(rtps.PUBLICATIONS_READER, rtps.PUBLICATIONS_WRITER, 1, listed)


def announcement(endpoint_set: int = 0b010100) -> bytes:
    listed = [
        (0x32, rtps.locator("127.0.0.1", 7410)),
        (0x31, rtps.locator("127.0.0.1", 7411)),
        (0x58, struct.pack("<I", endpoint_set)),
    ]
    return rtps.sample(rtps.SPDP_READER, rtps.SPDP_WRITER, 1, listed)


def data_in(submessage: bytes) -> rtps.Data:
    (part,) = received(submessage)
    assert isinstance(part, rtps.Data)
    return part


def payload_of(submessage: bytes) -> bytes:
    return data_in(submessage).payload


def test_what_is_written_is_read_back():
    (heartbeat,) = received(rtps.heartbeat(rtps.SUBSCRIPTIONS_READER, rtps.SPDP_WRITER, 7, 1))
    assert heartbeat == rtps.Heartbeat(writer=PEER + rtps.SPDP_WRITER, first=1, last=7)
    (gone,) = received(rtps.end_of(rtps.SPDP_READER, rtps.SPDP_WRITER, 3, TALKER_GID))
    assert isinstance(gone, rtps.Data)
    assert (gone.number, gone.gone, gone.key) == (3, True, TALKER_GID)


def test_what_is_for_another_participant_is_left_out():
    beat = rtps.heartbeat(rtps.SPDP_READER, rtps.SPDP_WRITER, 1, 1)
    assert received(rtps.to(OTHER), beat) == []
    assert len(received(rtps.to(OTHER), beat, rtps.to(OWN), beat)) == 1


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (bytes.fromhex("0000000007000000"), "KEEP_LAST (7)"),  # of Cyclone DDS 11
        (bytes.fromhex("0100000000000000"), "KEEP_ALL"),
        (struct.pack("<Ii", 9, 1), "UNKNOWN"),
        (None, "UNKNOWN"),
    ],
)
def test_the_history_of_an_endpoint_is_shown_where_it_is_announced(value, shown):
    listed = [(0x5A, TALKER_GID), (0x05, rtps.text("rt/x")), (0x07, rtps.text("y"))]
    listed += [] if value is None else [(0x40, value)]
    sample = rtps.sample(rtps.PUBLICATIONS_READER, rtps.PUBLICATIONS_WRITER, 1, listed)
    info = endpoint_in(payload_of(sample), Direction.PUBLISHER)
    assert f"\n  History (Depth): {shown}\n" in str(info)


@given(missing=st.sets(st.integers(1, 700), min_size=1))
def test_samples_are_asked_for_in_the_bitmap_of_the_standard(missing):
    wanted = sorted(missing)
    request = rtps.ask(rtps.PUBLICATIONS_READER, rtps.PUBLICATIONS_WRITER, wanted, 1)
    base, size = struct.unpack_from("<II", request, 4 + 12)  # behind the higher half of the base
    words = struct.unpack_from(f"<{(size + 31) // 32}I", request, 4 + 20)
    asked = [base + n for n in range(size) if words[n // 32] >> (31 - n % 32) & 1]
    assert asked == [n for n in wanted if n - wanted[0] < 256]
    assert len(request) == 4 + 20 + 4 * len(words) + 4


@given(st.binary(max_size=300), st.booleans())
def test_strange_datagrams_are_malformed_or_of_their_sender(noise, with_header):
    datagram = rtps.message(PEER, VENDOR, noise) if with_header else noise
    found: list[rtps.Part] = []
    with contextlib.suppress(ValueError):
        found.extend(rtps.parts(datagram, OWN))
    owners = {p.reader if isinstance(p, rtps.AckNack) else p.writer for p in found}
    assert all(owner.startswith(datagram[8:20]) for owner in owners)


@given(st.binary(max_size=80), st.integers(0, 60))
def test_strange_payloads_are_value_errors(noise, cut):
    whole = payload_of(publication("rt/chatter"))
    for payload in (noise, whole[:cut], whole[:4] + noise):
        for read in (lambda p: endpoint_in(p, Direction.PUBLISHER), contact_in, nodes_in):
            with contextlib.suppress(ValueError):
                read(payload)
    assert endpoint_in(whole, Direction.PUBLISHER).topic == "rt/chatter"


def test_a_stream_is_complete_when_all_that_was_promised_has_come_or_is_gone():
    stream = SampleStream(rtps.PUBLICATIONS_WRITER, rtps.PUBLICATIONS_READER)
    assert not stream.is_complete  # nothing has been promised yet
    writer = PEER + rtps.PUBLICATIONS_WRITER
    stream.take(rtps.Heartbeat(writer=writer, first=1, last=3))
    assert stream.missing() == [1, 2, 3]
    stream.take(rtps.Gap(writer=writer, numbers=frozenset({1, 3})))
    (sample,) = received(
        rtps.sample(rtps.PUBLICATIONS_READER, rtps.PUBLICATIONS_WRITER, 2, [(0x5A, TALKER_GID)])
    )
    stream.take(sample)
    assert stream.is_complete


def test_a_participant_without_ros_nodes_is_listed_with_its_endpoints():
    peer = Participant(PEER, data_in(announcement(0b000100)), "127.0.0.1")
    stream = peer.stream(rtps.PUBLICATIONS_WRITER)
    assert stream is not None
    for part in received(
        publication("Square", kind="ShapeType"),
        rtps.heartbeat(rtps.PUBLICATIONS_READER, rtps.PUBLICATIONS_WRITER, 1, 1),
    ):
        stream.take(part)
    assert peer.is_complete
    look = snapshot_of(0, [peer])
    assert (look.nodes, look.topic_types()) == ((), {})
    assert [(i.topic, i.type, i.node) for i in look.infos] == [("Square", "ShapeType", "")]


def test_a_ros_participant_is_complete_only_with_its_nodes():
    peer = Participant(PEER, data_in(announcement(0b000100)), "127.0.0.1")
    stream = peer.stream(rtps.PUBLICATIONS_WRITER)
    assert stream is not None
    for part in received(
        publication("ros_discovery_info"),
        rtps.heartbeat(rtps.PUBLICATIONS_READER, rtps.PUBLICATIONS_WRITER, 1, 1),
    ):
        stream.take(part)
    assert not peer.is_complete
    members = peer.stream(INFO_WRITER)
    assert members is not None
    body = bytes(16) + struct.pack("<I", 1) + struct.pack("<I", 2) + b"/\0\0\0"
    body += struct.pack("<I", 7) + b"talker\0\0" + struct.pack("<II", 0, 1) + TALKER_GID
    members.take(
        rtps.Data(
            writer=PEER + INFO_WRITER, number=4, payload=b"\0\1\0\0" + body, gone=False, key=b""
        )
    )
    members.take(rtps.Heartbeat(writer=PEER + INFO_WRITER, first=4, last=4))
    assert peer.is_complete
    look = snapshot_of(0, [peer])
    assert look.nodes == ("/talker",)
    assert look.infos[0].node == "/talker"


def test_missing_dds_values_get_their_defaults():
    payload = payload_of(publication("rt/a"))
    written, read = (endpoint_in(payload, d) for d in Direction)
    assert (written.reliability, read.reliability) == ("RELIABLE", "BEST_EFFORT")
    assert (written.durability, written.liveliness) == ("VOLATILE", "AUTOMATIC")
    assert str(written).endswith("Lifespan: Infinite\n  Deadline: Infinite\n  Liveliness: AUTOMATIC"
                                 "\n  Liveliness lease duration: Infinite")  # fmt: skip


@pytest.mark.parametrize(
    ("mangled", "plain"),
    [
        ("rt/ns/chatter", ("rt", "/ns/chatter")),
        ("rq/switchRequest", ("rq", "/switch")),
        ("rr/switchReply", ("rr", "/switch")),
        ("ros_discovery_info", None),
        ("Square", None),
    ],
)
def test_names_of_dds(mangled, plain):
    assert ros_name(mangled) == plain


def test_types_of_dds():
    assert ros_type("std_msgs::msg::dds_::String_") == "std_msgs/msg/String"
    assert ros_type("std_srvs::srv::dds_::SetBool_Request_", "rq") == "std_srvs/srv/SetBool"
    assert ros_type("ShapeType") == "ShapeType"


def test_actions_are_recognised_by_their_feedback():
    kind = "demo::action::dds_::Fold_FeedbackMessage_"
    common = {"reliability": "RELIABLE", "durability": "VOLATILE", "type": kind}
    infos = tuple(
        EndpointInfo(
            topic="rt/fold/_action/feedback", node=node, direction=direction.value, **common
        )
        for node, direction in (("/s", Direction.PUBLISHER), ("/c", Direction.SUBSCRIPTION))
    )
    look = GraphSnapshot(domain_id=0, nodes=("/c", "/s"), infos=infos)
    expected = [("/fold", ["demo/action/Fold"])]
    assert look.of_node("/s")["Action Servers"] == expected
    assert look.of_node("/c")["Action Clients"] == expected
    assert from_document(look.to_document()) == look


def test_only_pairs_of_ports_count(tmp_path, monkeypatch):
    first = multicast_port(3) + 10
    table = tmp_path / "net" / "udp"
    table.parent.mkdir()
    lines = [f" 0: 00000000:{port:04X} x x x x x x x 1 x" for port in (first, first + 1, first + 2)]
    table.write_text("\n".join(["head", *lines]), encoding="ascii")
    monkeypatch.setattr("launcher.posix.proc.ROOT", str(tmp_path))
    assert occupied_ports(3) == {first}


@pytest.mark.parametrize(
    ("environment", "plain"),
    [
        ({}, True),
        ({"RMW_IMPLEMENTATION": "rmw_fastrtps_cpp"}, True),
        ({"RMW_IMPLEMENTATION": "rmw_zenoh_cpp"}, False),
        ({"ROS_DISCOVERY_SERVER": "127.0.0.1:11811"}, False),
        ({"ROS_SECURITY_ENABLE": "true"}, False),
        ({"FASTDDS_BUILTIN_TRANSPORTS": "SHM"}, False),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}, False),
    ],
)
def test_unusual_discovery_settings_are_left_to_the_middleware(
    environment, plain, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    assert is_plain(environment) is plain
    (tmp_path / "DEFAULT_FASTRTPS_PROFILES.xml").touch()
    assert not is_plain(environment)


@pytest.mark.parametrize("number", [1, 2**32 + 5])
def test_a_relayed_message_reads_like_the_original(number: int):
    said = replace(data_in(publication("rt/chatter")), number=number)
    assert received(rtps.repeated(rtps.PUBLICATIONS_READER, said)) == [said]


def test_only_the_given_sockets_get_larger_buffers():
    with contextlib.ExitStack() as stack:
        ours, other = (
            stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for _ in range(2)
        )
        for one in (ours, other):
            one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        room = other.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)
        widen_sockets({str(os.fstat(ours.fileno()).st_ino)})
        assert ours.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) > room
        assert other.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) == room
