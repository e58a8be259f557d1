"""Mutated bags: the same for the same number."""

from __future__ import annotations

import contextlib
import random
import sqlite3
import struct
import zlib
from pathlib import Path

from mcap.opcode import Opcode

from launcher.bag.mcap.records import HEAD, MAGIC

_EXTREMES = [0, 1, 2**7, 2**8 - 1, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 2**40, 2**63, 2**64 - 1]
_TOKENS = [
    *"[]{}:,-|>!&*'\"#%@`\n\t \0",
    "[" * 5000, "- " * 3000, "{a: " * 200, "*a", "&a [*a]", "&a ", "!!int x", "!!python/x ",
    "null", "true", "-1", "1e999", str(2**64 - 1), "9" * 5000, "1:2:3", "2001-99-99", "<<: *a",
    "0x" + "f" * 40, "\\uD800", '"\\uD800"', "---\n", "...\n", "x" * 100_000, "\u0085", "\ufeff",
]  # fmt: skip
_VALUES = [
    "", "0", "-1", "1.5", str(2**63 - 1), str(2**64 - 1), "null", "true", "[]", "{}", "[[]]", "x",
    "reliable", "keep_last", "transient_local", "/text", "mcap", "sqlite3", "zstd", "message",
    "file", "../x", "/dev/zero", '"\\uD800"', '"\\e[2J"', "2001-01-01", "!!binary AA==", ".nan",
]  # fmt: skip
_STATEMENTS = [
    "UPDATE messages SET data = 5",
    "UPDATE messages SET data = zeroblob(3000000) WHERE id = 1",
    "UPDATE messages SET timestamp = 9223372036854775807 WHERE id = 2",
    "UPDATE messages SET timestamp = -9223372036854775808 WHERE id = 2",
    "UPDATE messages SET timestamp = 'x'",
    "UPDATE messages SET timestamp = 1.5",
    "UPDATE messages SET topic_id = 99",
    "UPDATE topics SET name = x'ff'",
    "UPDATE topics SET name = char(27) || '[2J'",
    "UPDATE topics SET type = ''",
    "UPDATE topics SET type = '../../x/y'",
    "UPDATE topics SET serialization_format = 'json'",
    "UPDATE topics SET offered_qos_profiles = '- depth: [1'",
    "UPDATE topics SET offered_qos_profiles = '- {depth: 99999999999999}'",
    "UPDATE topics SET offered_qos_profiles = '- {history: 77, deadline: {sec: -5, nsec: x}}'",
    "UPDATE message_definitions SET encoded_message_definition = 'std_msgs/String a'",
    "UPDATE message_definitions SET encoded_message_definition = 'uint8[9999999999] data'",
    "DROP TABLE messages",
    "DROP TABLE topics",
    "ALTER TABLE messages RENAME COLUMN data TO content",
    "CREATE TRIGGER t AFTER UPDATE ON messages BEGIN DELETE FROM topics; END",
    "CREATE TABLE other AS WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n LIMIT "
    "9999) SELECT x FROM n",
]


def mutate(path: Path, kind: str, number: int) -> None:
    """Change a file in one to three ways."""
    random_ = random.Random(f"{kind} {number}")
    if kind.startswith("db3") and random_.random() < 0.3:
        _execute(path, random_)
        return
    data = bytearray(path.read_bytes())
    for _ in range(random_.choice([1, 1, 1, 2, 3])):
        if kind == "metadata" and random_.random() < 0.6:
            _tokens(data, random_)
        elif kind == "mcap plain" and random_.random() < 0.5:
            _record(data, random_)
        else:
            _bytes(data, random_)
    path.write_bytes(data)


def _execute(path: Path, random_: random.Random) -> None:
    connection = sqlite3.connect(path)
    for statement in random_.sample(_STATEMENTS, random_.choice([1, 1, 2])):
        with contextlib.suppress(sqlite3.Error):
            connection.execute(statement)
    connection.commit()
    connection.close()


def _tokens(data: bytearray, random_: random.Random) -> None:
    """Put a token of YAML in place of a word, or between two."""
    if random_.random() < 0.6:
        ends = [at for at in range(len(data)) if data[at : at + 1] == b"\n"]
        end = random_.choice(ends or [len(data)])
        start = max(data.rfind(b" ", 0, end) + 1, data.rfind(b"\n", 0, end) + 1)
        data[start:end] = random_.choice(_VALUES).encode()
        return
    words = [0, *(at for at, byte in enumerate(data) if byte in b" \n:"), len(data)]
    start = random_.randrange(len(words) - 1)
    end = start + random_.choice([0, 1, 1, 2, 5])
    token = random_.choice(_TOKENS).encode()
    data[words[start] : words[min(end, len(words) - 1)]] = token


def _bytes(data: bytearray, random_: random.Random) -> None:
    at = random_.randrange(len(data) + 1)
    if random_.random() < 0.2:  # what a reader begins with
        at = random_.choice([at % 128, max(0, len(data) - 1 - at % 256)])
    length = random_.choice([1, 2, 8, 40, 400])
    match random_.randrange(8):
        case 0 | 1:
            if at < len(data):
                data[at] ^= 1 << random_.randrange(8)
        case 2:
            data[at : at + length] = random_.randbytes(length)
        case 3:
            form = random_.choice("HIQ")
            value = random_.choice(_EXTREMES) % (1 << 8 * struct.calcsize(f"<{form}"))
            data[at : at + struct.calcsize(f"<{form}")] = struct.pack(f"<{form}", value)
        case 4:
            del data[at:]
        case 5:
            del data[at : at + length]
        case 6:
            data[at:at] = data[at : at + length]
        case 7:
            data[at : at + length] = bytes(length)


def _record(data: bytearray, random_: random.Random) -> None:
    """Change a field of a record of MCAP."""
    places = []
    offset = len(MAGIC)
    while offset + HEAD.size <= len(data) - len(MAGIC):
        opcode, length = HEAD.unpack_from(data, offset)
        places.append((offset, opcode, length))
        offset += HEAD.size + length
    if not places:
        return
    offset, opcode, length = random_.choice(places)
    at = offset + random_.choice([0, 1, HEAD.size + random_.randrange(max(1, min(length, 64)))])
    form = random_.choice("BHIQ")
    value = random_.choice(_EXTREMES) % (1 << 8 * struct.calcsize(f"<{form}"))
    data[at : at + struct.calcsize(f"<{form}")] = struct.pack(f"<{form}", value)
    if opcode == Opcode.CHUNK and random_.random() < 0.5:  # as one who means it would do
        start = offset + HEAD.size
        struct.pack_into("<I", data, start + 24, zlib.crc32(data[start + 40 : start + length]))
