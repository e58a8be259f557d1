"""The QoS of a topic is the same in `metadata.yaml` and in all files: all readers see all."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.rosbag2.metadata import parse_qos
from rosbags.typesys import Stores, get_typestore

from launcher.bag import check, metadata
from launcher.bag.bag_model import Qos
from launcher.bag.reader import Bag
from launcher.bag.ros.sinks import FileSink, Ring
from launcher.bag.writer import BagWriter, Storage
from tests.support.bags import (
    QOS,
    START_NS,
    agreed_counts,
    convert,
    counting,
    counts_by_readers,
    message,
    string_cdr,
    string_topic,
    write_bag,
)

LATCHED = {**QOS, "durability": "transient_local"}
BEST_EFFORT = {**QOS, "reliability": "best_effort"}


def changing(folder: Path, storage: Storage | None = None) -> BagWriter:
    """A bag that is being written: another publisher comes after the first messages."""
    writer = BagWriter(str(folder), storage)
    writer.add_topic(string_topic("/a"))
    for n in range(20):
        if n == 10:
            writer.set_qos("/a", [QOS, BEST_EFFORT])
        writer.write(message("/a", n * 0.1, f"message {n}", n))
    return writer


@pytest.mark.parametrize(
    "storage",
    [Storage(), Storage(max_duration_ns=3 * 10**8), Storage(mode="file"), Storage(mode="message")],
    ids=["whole", "split", "file", "message"],
)
def test_a_publisher_with_other_qos_comes_later(tmp_path: Path, storage: Storage):
    changing(tmp_path / "b", storage).close()
    assert agreed_counts(tmp_path / "b") == {"/a": 20}


def test_what_is_known_at_the_first_message_counts(tmp_path: Path):
    writer = BagWriter(str(tmp_path / "b"), Storage(max_duration_ns=10**8))
    for name in ("/a", "/none"):
        writer.add_topic(string_topic(name))
        writer.set_qos(name, [LATCHED])
    writer.write(message("/a", 0, "x"))
    writer.set_qos("/a", [QOS])
    writer.set_qos("/none", [LATCHED, QOS])
    writer.write(message("/a", 1, "x"))  # a new file
    writer.set_qos("/none", [QOS])  # too late: it has a channel in the first one
    writer.close()
    assert agreed_counts(tmp_path / "b") == {"/a": 2, "/none": 0}
    found = metadata.read(str(tmp_path / "b"))
    assert found is not None
    assert {topic.name: list(topic.qos) for topic in found.topics} == {
        "/a": [LATCHED],
        "/none": [LATCHED, QOS],
    }


def test_a_full_disk(tmp_path: Path):
    writer = changing(tmp_path / "b")
    writer.flush()
    writer.rescue()
    assert agreed_counts(tmp_path / "b") == {"/a": 20}


def test_a_killed_recorder(tmp_path: Path):
    writer = changing(tmp_path / "b")
    writer.flush()
    check.repair(check.check(str(tmp_path / "b")), "jazzy")
    assert agreed_counts(tmp_path / "b") == {"/a": 20}


def test_snapshots(tmp_path: Path):
    ring, sink = Ring(10**6), FileSink(BagWriter(str(tmp_path / "b")), 10**6)
    ring.add_topic(string_topic("/a"))
    for profiles in ([QOS], [QOS, BEST_EFFORT]):
        ring.set_qos("/a", profiles)
        for topic in ring.topics.values():
            sink.add_topic(topic)
        for one in counting("/a", 5):
            sink.put(one, b"p")
    assert sink.finish() is None
    assert agreed_counts(tmp_path / "b") == {"/a": 10}


def contradicting(folder: Path, *profiles: Qos) -> Path:
    """A bag whose metadata have these profiles, and its file another one."""
    write_bag(folder, counting("/a", 10))
    known = metadata.read(str(folder))
    assert known is not None
    topics = [replace(topic, qos=profiles) for topic in known.topics]
    metadata.write(str(folder), replace(known, topics=topics))
    return folder


@pytest.mark.parametrize("profiles", [[QOS, LATCHED], [LATCHED], []])
def test_a_contradiction_is_found_and_repaired(tmp_path: Path, profiles: list[Qos]):
    bag = contradicting(tmp_path / "b", *profiles)
    assert counts_by_readers(bag)["rosbags, folder"] == {"/a": 0}
    report = check.check(str(bag))
    assert report.problems == [
        "metadata.yaml has other QoS of /a than b_0.mcap, so that some readers leave out its "
        "messages (bag convert writes a bag that has all)"
    ]
    check.repair(report, "jazzy")
    assert agreed_counts(bag) == {"/a": 10}


def test_converting_a_contradiction(tmp_path: Path):
    bag = contradicting(tmp_path / "b", QOS, LATCHED)
    convert(bag, "-o", tmp_path / "copy", "-d", "0.4")
    assert agreed_counts(tmp_path / "copy") == {"/a": 10}
    changing(tmp_path / "c").close()
    convert(bag, tmp_path / "c", "-o", tmp_path / "both")
    assert agreed_counts(tmp_path / "both") == {"/a": 30}
    convert(bag, "-o", tmp_path / "one.mcap")
    assert Bag(str(tmp_path / "one.mcap")).topics[0].qos == (QOS, LATCHED)


def test_a_topic_with_several_channels_of_another_library(tmp_path: Path):
    bag = tmp_path / "theirs"
    store = get_typestore(Stores.ROS2_JAZZY)
    with Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for number, qos in enumerate(([], [BEST_EFFORT]), 1):
            connection = writer.add_connection(
                "/a", "std_msgs/msg/String", typestore=store, offered_qos_profiles=parse_qos(qos)
            )
            for n in range(5 * number):
                writer.write(connection, START_NS + n, string_cdr("x"))
    assert agreed_counts(bag) == {"/a": 15}
    assert [one["reliability"] for one in Bag(str(bag)).topics[0].qos] == ["best_effort"]
    convert(bag, "-o", tmp_path / "copy")
    assert agreed_counts(tmp_path / "copy") == {"/a": 15}
