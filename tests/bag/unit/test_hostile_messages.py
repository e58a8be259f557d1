"""Compressed data, messages and types that say more than they have."""

from __future__ import annotations

import struct
import tracemalloc
from pathlib import Path

import lz4.frame
import pytest
import zstandard
from mcap.records import Chunk

from launcher.bag import check, compression
from launcher.bag.bag_model import BagError, Definition, Topic
from launcher.bag.decode import decoder
from tests.bag.unit.damaged_files import foreign_file, texts

# ---- compressed data


def compress(data: bytes, name: str) -> bytes:
    return zstandard.compress(data) if name == "zstd" else lz4.frame.compress(data)


@pytest.mark.parametrize("name", ["zstd", "lz4"])
def test_decompression_stops_at_the_declared_size(name: str):
    bomb = compress(bytes(300 << 20), name)
    tracemalloc.start()
    with pytest.raises(ValueError, match="more than 1000 bytes"):
        compression.exactly(bomb, 1000, name)
    with pytest.raises(ValueError, match=r"it would have|it has"):
        compression.exactly(bomb[:1000], 2**62, name)
    assert tracemalloc.get_traced_memory()[1] < 20 << 20
    tracemalloc.stop()


@pytest.mark.parametrize("name", ["zstd", "lz4", ""])
@pytest.mark.parametrize("size", [0, 1, 99, 101])
def test_another_size_than_the_declared_one_is_damage(name: str, size: int):
    data = b"x" * 100
    packed = compress(data, name) if name else data
    assert compression.exactly(packed, 100, name) == data
    with pytest.raises(ValueError, match="it has"):
        compression.exactly(packed, size, name)


def test_a_chunk_that_is_larger_than_it_says(tmp_path: Path):
    def edits(chunk: Chunk) -> None:
        chunk.uncompressed_size -= 1

    path = foreign_file(tmp_path / "a.mcap", edits)
    with pytest.raises(BagError, match=r"is damaged: a chunk is damaged \(it has more than"):
        texts(path)
    assert "a chunk is damaged" in check.check(str(path)).files[0].faults[0].text


@pytest.mark.parametrize("size", [2**62, 2**40, 400 << 20])
def test_a_compressed_message_that_says_a_huge_size(size: int):
    frame = b"\x28\xb5\x2f\xfd\xe0" + struct.pack("<Q", size) + zstandard.compress(b"x")[5:]
    with pytest.raises(ValueError, match="a compressed message is damaged"):
        compression.message_decompressor()(frame)


# ---- sizes of messages


def bytes_topic(text: str, name: str = "x_msgs/msg/X") -> Topic:
    return Topic(name="/x", type=name, definition=Definition(text=text))


@pytest.mark.parametrize(
    ("text", "data"),
    [
        ("string data\n", struct.pack("<I", 7) + b"hello\0"),
        ("string data\n", struct.pack("<I", 2**32 - 1) + b"hello\0"),
        ("uint8[] data\n", struct.pack("<I", 7) + b"hello\0"),
        ("uint8[7] data\n", b"hello\0"),
        ("float64[] data\n", struct.pack("<I4xd", 2, 1.0)),
        ("float64[200000000] data\n", struct.pack("<d", 1.0)),
        ("string[] data\n", struct.pack("<I", 2**32 - 1) + b"hello\0"),
        ("x_msgs/Y[] data\n" + "=" * 80 + "\nMSG: x_msgs/Y\nint8 a\n", struct.pack("<I", 2**31)),
    ],
)
def test_what_is_longer_than_its_message_is_damage(text: str, data: bytes):
    tracemalloc.start()
    with pytest.raises(BagError, match="/x: a message is not a x_msgs/msg/X"):
        decoder(bytes_topic(text))(b"\0\1\0\0" + data)
    assert tracemalloc.get_traced_memory()[1] < 5 << 20
    tracemalloc.stop()


def nested(depth: int) -> str:
    parts = [f"MSG: x_msgs/T{n}\nx_msgs/T{n + 1} a" for n in range(depth)]
    parts.append(f"MSG: x_msgs/T{depth}\nint8 a")
    return "\n".join(["x_msgs/T0 a", *(f"{'=' * 80}\n{part}" for part in parts)])


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (nested(3000), "it is nested more than 100 levels deep"),
        ("x_msgs/X a\n", "x_msgs/X contains itself"),
        (f"x_msgs/Y a\n{'=' * 80}\nMSG: x_msgs/Y\nx_msgs/Y[] a\n", "x_msgs/Y contains itself"),
    ],
)
def test_types_that_no_message_can_have(text: str, reason: str):
    with pytest.raises(BagError) as caught:
        decoder(bytes_topic(text))
    assert caught.value.message == f"/x: the definition of x_msgs/msg/X cannot be read: {reason}"


def test_types_may_be_nested_as_deeply_as_any_real_one():
    decode = decoder(bytes_topic(nested(90)))
    value = decode(b"\0\1\0\0\5")
    for _ in range(92):
        value = value.a
    assert value == 5


def test_a_definition_that_cannot_be_read_prints_nothing(capfd):
    topic = bytes_topic("string 1dat\n")
    with pytest.raises(BagError, match=r"cannot be read: '1dat' is an invalid .*'string 1dat'"):
        decoder(topic)
    assert capfd.readouterr() == ("", "")
