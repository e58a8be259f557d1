"""Bags for tests, without ROS: string messages in CDR."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy
from mcap.reader import make_reader
from rosbags.interfaces import Connection
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from launcher.bag import info
from launcher.bag import verbs as bag_verb
from launcher.bag.bag_model import Definition, Message, Topic
from launcher.bag.check import check
from launcher.bag.reader import Bag
from launcher.bag.writer import BagWriter, Storage

START_NS = 1_700_000_000_000_000_000
STRING_HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
QOS = {
    "history": "unknown",
    "depth": 0,
    "reliability": "reliable",
    "durability": "volatile",
    "deadline": {"sec": 9223372036, "nsec": 854775807},
    "lifespan": {"sec": 9223372036, "nsec": 854775807},
    "liveliness": "automatic",
    "liveliness_lease_duration": {"sec": 9223372036, "nsec": 854775807},
    "avoid_ros_namespace_conventions": False,
}


def string_topic(name: str) -> Topic:
    return Topic(
        name=name,
        type="std_msgs/msg/String",
        qos=[QOS],
        type_hash=STRING_HASH,
        definition=Definition(text="string data\n"),
    )


def string_cdr(text: str) -> bytes:
    """A serialized `std_msgs/msg/String`."""
    data = text.encode() + b"\0"
    return struct.pack("<4sI", b"\0\1\0\0", len(data)) + data


def text_of(data: bytes) -> str:
    return data[8:].rstrip(b"\0").decode()


def message(topic: str, at_s: float, text: str, sequence: int = 0) -> Message:
    """A string, received at this time after `START_NS` and published 1 ms before."""
    log_ns = START_NS + round(at_s * 1e9)
    return Message(topic, log_ns, log_ns - 1_000_000, sequence, string_cdr(text))


def write_bag(
    folder: Path,
    messages: Sequence[Message],
    *,
    storage: Storage | None = None,
    flush_every: int = 10,
) -> Path:
    """A bag of string topics; a chunk for each ten messages."""
    writer = BagWriter(str(folder), storage, ros_distro="jazzy")
    for topic in dict.fromkeys(one.topic for one in messages):
        writer.add_topic(string_topic(topic))
    for number, one in enumerate(messages, 1):
        writer.write(one)
        if number % flush_every == 0:
            writer.flush()
    writer.close()
    return folder


def counting(topic: str, number: int, period_s: float = 0.1) -> list[Message]:
    return [message(topic, n * period_s, f"message {n}", n + 1) for n in range(number)]


def times_of(bag: Bag) -> dict[str, list[int]]:
    """Those of the messages of each topic."""
    found: dict[str, list[int]] = {}
    for topic, times in bag.times():
        found.setdefault(topic, []).extend(times)
    return found


def foreign_bag(
    folder: Path,
    messages: Sequence[tuple[str, str, int, object]],
    *,
    plugin: StoragePlugin = StoragePlugin.SQLITE3,
    version: int = 9,
) -> Path:
    """A bag by the library `rosbags`; messages are (topic, type, ns, keywords of the message)."""
    store = get_typestore(Stores.ROS2_JAZZY)
    with Writer(folder, version=version, storage_plugin=plugin) as writer:
        connections: dict[str, Connection] = {}
        for topic, type_name, log_ns, fields in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, type_name, typestore=store)
            data = store.serialize_cdr(_built(store, type_name, fields), type_name)
            writer.write(connections[topic], log_ns, data)
    return folder


def _built(store: Typestore, type_name: str, fields: object) -> object:
    """A message of keywords; {"type": {...}} in them are messages themselves."""
    if isinstance(fields, dict):
        values = {name: _value(store, one) for name, one in fields.items()}
        return store.types[type_name](**values)
    return fields


def _value(store: Typestore, value: object) -> object:
    if isinstance(value, dict):
        ((type_name, fields),) = value.items()
        return _built(store, type_name, fields)
    return [_value(store, one) for one in value] if isinstance(value, list) else value


def counts_by_readers(bag: Path) -> dict[str, dict[str, int]]:
    """Reader -> the number of messages of each topic in a folder."""
    files = sorted(bag.glob("*.mcap"))
    found = {
        "bag info": {one.name: info.read(str(bag)).count(one) for one in Bag(str(bag)).topics},
        "rosbags, folder": _counts_by_rosbags([bag]),
    }
    if files:  # and not compressed ones
        found["rosbags, files"] = _counts_by_rosbags(files)
        found["mcap"] = _counts_by_mcap(files)
    return found


def agreed_counts(bag: Path) -> dict[str, int]:
    """The number of messages of each topic of a whole bag, in which all readers agree."""
    assert check(str(bag)).is_whole
    found = counts_by_readers(bag)
    counts = found["bag info"]
    assert all(one == counts for one in found.values()), found
    return counts


def _counts_by_rosbags(paths: Iterable[Path]) -> dict[str, int]:
    counts: Counter[str] = Counter()
    for path in paths:
        with Reader(path) as reader:
            counts.update({one.topic: 0 for one in reader.connections})
            counts.update(connection.topic for connection, *_ in reader.messages())
    return dict(counts)


def _counts_by_mcap(paths: Iterable[Path]) -> dict[str, int]:
    counts: Counter[str] = Counter()
    for path in paths:
        with path.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=True)
            summary = reader.get_summary()
            assert summary is not None
            counts.update({one.topic: 0 for one in summary.channels.values()})
            counts.update(channel.topic for _, channel, _ in reader.iter_messages())
    return dict(counts)


def convert(*words: object) -> None:
    assert bag_verb.main(["convert", *map(str, words)]) == 0


def contents(path: Path) -> list[tuple[str, str]]:
    assert check(str(path)).is_whole
    return [(one.topic, text_of(one.data)) for one in Bag(str(path)).messages()]


def typed_bag(folder: Path, topic: Topic) -> Path:
    writer = BagWriter(str(folder))
    writer.add_topic(topic)
    writer.write(message(topic.name, 0, "x"))
    writer.close()
    return folder


def imu_bag(folder: Path, number: int = 3) -> Path:
    def vector(x: float) -> dict[str, object]:
        return {"geometry_msgs/msg/Vector3": {"x": x, "y": float("nan"), "z": float("inf")}}

    stamp = {"builtin_interfaces/msg/Time": {"sec": 5, "nanosec": 7}}
    nine = numpy.arange(9, dtype=numpy.float64)
    messages: list[tuple[str, str, int, object]] = [
        (
            "/imu",
            "sensor_msgs/msg/Imu",
            START_NS + n,
            {
                "header": {"std_msgs/msg/Header": {"stamp": stamp, "frame_id": 'a "b", ü'}},
                "orientation": {
                    "geometry_msgs/msg/Quaternion": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
                },
                "orientation_covariance": nine,
                "angular_velocity": vector(n / 2),
                "angular_velocity_covariance": nine,
                "linear_acceleration": vector(0.1),
                "linear_acceleration_covariance": nine,
            },
        )
        for n in range(number)
    ]
    messages.append(("/text", "std_msgs/msg/String", START_NS + number, {"data": "t"}))
    return foreign_bag(folder, messages)
