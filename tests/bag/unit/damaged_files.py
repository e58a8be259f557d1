"""Files of bags, what they hold, and changes of their bytes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from mcap.writer import Writer

from launcher.bag import check
from launcher.bag.mcap.records import HEAD, MAGIC
from launcher.bag.reader import Bag
from tests.support.bags import string_cdr, text_of

EVERYTHING = [f"message {n}" for n in range(95)]


def storage_of(folder: Path) -> Path:
    return next(folder.glob("*.mcap"))


def texts(path: Path) -> list[str]:
    return [text_of(one.data) for one in Bag(str(path)).messages()]


def records(data: bytes) -> list[tuple[int, int, int]]:
    """(offset, opcode, length) of all records of a whole file."""
    found, offset = [], len(MAGIC)
    while offset < len(data) - len(MAGIC):
        opcode, length = HEAD.unpack_from(data, offset)
        found.append((offset, opcode, length))
        offset += HEAD.size + length
    return found


def edit(path: Path, offset: int, new: bytes) -> None:
    with path.open("r+b") as file:
        file.seek(offset)
        file.write(new)


def repaired(folder: Path) -> check.BagReport:
    check.repair(check.check(str(folder)), "jazzy")
    report = check.check(str(folder))
    assert report.is_whole, report
    return report


def foreign_file(path: Path, edits: Callable[[Chunk], None] | None = None) -> Path:
    """A file of another writer, without checksums of data and summary."""
    with path.open("wb") as stream:
        writer = Writer(stream, enable_crcs=False)
        writer.start("ros2")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
        channel = writer.register_channel("/a", "cdr", schema)
        for number in range(20):
            writer.add_message(channel, 10**9 + number, string_cdr(f"m{number}"), 0)
        writer.finish()
    if edits is not None:
        rewrite_chunk(path, edits)
    return path


def rewrite_chunk(path: Path, edits: Callable[[Chunk], None]) -> None:
    """Replace the first chunk by an edited one of the same length."""
    data = path.read_bytes()
    offset, _, length = next(one for one in records(data) if one[1] == Opcode.CHUNK)
    with path.open("rb") as stream:
        reader = StreamReader(stream, emit_chunks=True)
        chunk = next(one for one in reader.records if isinstance(one, Chunk))
    edits(chunk)
    builder = RecordBuilder()
    chunk.write(builder)
    new = builder.end()
    assert len(new) == HEAD.size + length
    edit(path, offset, new)
