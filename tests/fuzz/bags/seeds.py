"""Whole bags of each kind, to be mutated."""

from __future__ import annotations

import shutil
import struct
from collections.abc import Callable
from pathlib import Path

from mcap.writer import CompressionType, Writer

from launcher.bag import metadata
from launcher.bag.bag_model import Definition, Message, Topic
from launcher.bag.check import check
from launcher.bag.reader import Bag
from launcher.bag.writer import BagWriter, Storage
from tests.support.bags import QOS, START_NS, foreign_bag, imu_bag, string_cdr, string_topic

_POINTS = """std_msgs/Header header
geometry_msgs/Point32[] points
uint8[] raw
string<=20[<=3] names
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Point32
float32 x
float32 y
float32 z
"""


def _points_cdr(number: int) -> bytes:
    names = struct.pack("<II2s2xI3s", 2, 2, b"a\0", 3, b"bc\0")
    parts = struct.pack("<4siIIs3xI3f", b"\0\1\0\0", number, 7, 1, b"", 1, 1.0, 2.0, 3.0)
    return parts + struct.pack("<I4s", 4, b"rawb") + names


def _event_cdr(number: int) -> bytes:
    head = struct.pack("<4sB3xiI16sxxxxq", b"\0\1\0\0", number % 4, 5, 6, b"c" * 16, number)
    return head + struct.pack("<II", 0, 0)


TOPICS = (
    string_topic("/text"),
    Topic(
        name="/points",
        type="x_msgs/msg/Points",
        qos=[QOS, {**QOS, "reliability": "best_effort"}],
        definition=Definition(text=_POINTS),
    ),
    Topic(name="/s/_service_event", type="std_srvs/srv/Trigger_Event", qos=[QOS]),
)


def messages() -> list[Message]:
    found = []
    for number in range(12):
        log_ns = START_NS + number * 100_000_000
        for topic, data in (
            ("/text", string_cdr(f"message {number}")),
            ("/points", _points_cdr(number)),
            ("/s/_service_event", _event_cdr(number)),
        ):
            found.append(Message(topic, log_ns, log_ns - 1000, number, data))
    return found


def _own(storage: Storage) -> Callable[[Path], None]:
    def write(folder: Path) -> None:
        writer = BagWriter(str(folder), storage, ros_distro="jazzy", custom_data={"a": "b"})
        for topic in TOPICS:
            writer.add_topic(topic)
        for number, message in enumerate(messages()):
            writer.write(message)
            if number % 12 == 11:
                writer.flush()
        writer.close()

    return write


def _plain(folder: Path) -> None:
    """Without compression and checksums, so that each mutated byte is read; with an attachment."""
    folder.mkdir()
    with (folder / "plain_0.mcap").open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.NONE, enable_crcs=False)
        writer.start("ros2")
        channels = {}
        for topic in TOPICS:
            text = topic.definition.text.encode() if topic.definition else b""
            schema = writer.register_schema(topic.type, "ros2msg", text)
            profiles = {"offered_qos_profiles": metadata.qos_text(topic.qos)}
            channels[topic.name] = writer.register_channel(topic.name, "cdr", schema, profiles)
        for number, one in enumerate(messages()):
            channel = channels[one.topic]
            writer.add_message(channel, one.log_ns, one.data, one.publish_ns, one.sequence)
            if number % 12 == 11:
                writer.flush()
        writer.add_attachment(1, 2, "a.txt", "text/plain", b"attached")
        writer.finish()


def _sqlite(folder: Path) -> None:
    texts = [
        ("/text", "std_msgs/msg/String", START_NS + n * 10**8, {"data": f"message {n}"})
        for n in range(12)
    ]
    foreign_bag(folder, texts)


_WRITERS: dict[str, Callable[[Path], None]] = {
    "mcap": _own(Storage()),
    "mcap plain": _plain,
    "mcap lz4": _own(Storage(chunk_compression="lz4")),
    "mcap messages": _own(Storage(mode="message")),
    "mcap file": _own(Storage(mode="file")),
    "db3": _sqlite,
    "db3 imu": lambda folder: shutil.move(imu_bag(folder.with_name("imu")), folder),
    "metadata": _own(Storage()),
}
KINDS = tuple(_WRITERS)


def write_all(folder: Path) -> None:
    """A bag of each kind, in a folder of its name."""
    for kind, write in _WRITERS.items():
        write(folder / kind)
        assert check(str(folder / kind)).files[0].is_whole
        assert len(list(Bag(str(folder / kind)).messages()))


def mutable(folder: Path, kind: str) -> Path:
    """The file of a bag that is mutated."""
    if kind == "metadata":
        return folder / metadata.FILE
    return next(one for one in folder.iterdir() if one.name != metadata.FILE)
