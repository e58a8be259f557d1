"""How fast a bag is recorded without loss, and how fast a large one is read.

`limit`: two publishers, RELIABLE, of messages of 64 B to 4 MB (random bytes), faster and faster.
`bare` is an rclpy program with the same subscriptions that only counts; its limit is the first rate
at which it misses a message, or the highest that the publishers reach. The recorder then gets parts
and multiples of that rate. CPU time, at half of it, is compared with that of `bare` and of a `dd`
that writes the same bytes: who records has to do both.
`large`: 2 GB in messages of 16 kB, against `cat`, and memory against that for 200 MB.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import sqlite3
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from benchmarks.footprint import cpu_s
from benchmarks.harness import Row, scratch
from benchmarks.ros.verbs import ros_domain
from launcher.bag.bag_model import Definition, Message, Topic
from launcher.bag.reader import Bag
from launcher.bag.writer import BagWriter, Storage
from launcher.ros.topics.qos import LISTEN_DEPTH

TOPICS = ("/limit_0", "/limit_1")
BEGIN_HZ = {64: 10_000, 1024: 10_000, 16_384: 6_000, 262_144: 600, 4_194_304: 40}
FACTOR, STEPS = 1.25, 10
STEP_S, DRAIN_S = 0.8, 0.6
PARTS = (0.5, 0.7, 0.85, 1.0, 1.2)  # of the limit of the bare subscriptions
LEAST_PART, CPU_LIMIT = 0.7, 1.5
BEHIND = 0.9  # of a rate: publishers that reach less have no more to give
HEAD_BYTES = 16  # of a serialized UInt8MultiArray without dimensions
LARGE_MB, SMALL_MB, LARGE_MESSAGE = 2000, 200, 16_384
MEMORY_LIMIT = 1.3
LEAST_SPEED = {"info": 0.15, "convert": 0.01, "play": 0.015}

TYPE = "std_msgs/msg/UInt8MultiArray"
_LINE = "=" * 80
DEFINITION = f"""MultiArrayLayout layout
uint8[] data
{_LINE}
MSG: std_msgs/MultiArrayLayout
MultiArrayDimension[] dim
uint32 data_offset
{_LINE}
MSG: std_msgs/MultiArrayDimension
string label
uint32 size
uint32 stride
"""
SCHEMA = """
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
  serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL,
  type_description_hash TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,
  timestamp INTEGER NOT NULL, data BLOB NOT NULL);
CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL,
  encoding TEXT NOT NULL, encoded_message_definition TEXT NOT NULL,
  type_description_hash TEXT NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
"""

# Reads lines "step rate seconds", and prints for each how many it has published, and in what time.
PUBLISHER = f"""
import os, sys, time, rclpy
from rclpy.qos import QoSProfile
from std_msgs.msg import UInt8MultiArray
topic, size = sys.argv[1], int(sys.argv[2])
rclpy.init()
node = rclpy.create_node("source_" + topic[1:])
depth = max(20, min(1000, 64_000_000 // size))
publisher = node.create_publisher(UInt8MultiArray, topic, QoSProfile(depth=depth))
body, copies = size - {HEAD_BYTES}, max(2, min(500, 8_000_000 // size))
noise = os.urandom(copies * size)
head = bytes([0, 1, 0, 0]) + bytes(8) + body.to_bytes(4, "little")
while publisher.get_subscription_count() < 1:
    time.sleep(0.02)
time.sleep(0.5)
print("ready", flush=True)
for line in sys.stdin:
    step, rate, seconds = map(float, line.split())
    first = bytes([int(step)])
    messages = [head + first + noise[n * size : n * size + body - 1] for n in range(copies)]
    total, burst, sent = max(1, round(rate * seconds)), max(1, round(rate / 500)), 0
    start = time.monotonic()
    while sent < total and time.monotonic() - start < 1.5 * seconds:
        wait_s = start + sent / rate - time.monotonic()
        if wait_s > 0.0002:
            time.sleep(wait_s)
        for _ in range(min(burst, total - sent)):
            publisher.publish(messages[sent % copies])
            sent += 1
    print(sent, time.monotonic() - start, flush=True)
"""

# Prints for each line that it reads how many messages of each step have come.
BARE = f"""
import contextlib, json, sys, threading, rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import UInt8MultiArray
rclpy.init()
node = rclpy.create_node("bare")
counts = [0] * 256
def take(message):
    counts[message[{HEAD_BYTES}]] += 1
for topic in {TOPICS}:
    node.create_subscription(UInt8MultiArray, topic, take, {LISTEN_DEPTH}, raw=True)
def answer():
    for line in sys.stdin:
        print(json.dumps(counts), flush=True)
threading.Thread(target=answer, daemon=True).start()
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(node)
"""


class Step(NamedTuple):
    """What was published at a rate, the rate that was reached, and the CPU time of the receiver."""

    sent: int
    reached_hz: float
    cpu_s: float


class Sources:
    """The publishers, beside a program that receives from them."""

    def __init__(self, size: int, receiver: subprocess.Popen[str]) -> None:
        self._receiver = receiver
        self._step = 0
        self._programs = [_talking("-c", PUBLISHER, topic, str(size)) for topic in TOPICS]
        for program in self._programs:
            assert _line(program) == "ready"

    def publish(self, rate_hz: float) -> Step:
        """At this rate, for `STEP_S`; then wait until it must have come."""
        before = cpu_s(self._receiver.pid)
        for program in self._programs:
            _say(program, f"{self._step} {rate_hz / len(TOPICS)} {STEP_S}")
        found = [_line(program).split() for program in self._programs]
        time.sleep(DRAIN_S)
        self._step += 1
        sent = sum(int(number) for number, _ in found)
        reached_hz = sent / max(float(seconds) for _, seconds in found)
        return Step(sent, reached_hz, cpu_s(self._receiver.pid) - before)

    def close(self) -> None:
        for program in self._programs:
            program.communicate()


def _talking(*words: str) -> subprocess.Popen[str]:
    pipe = subprocess.PIPE
    return subprocess.Popen([sys.executable, *words], stdin=pipe, stdout=pipe, text=True)


def _say(program: subprocess.Popen[str], line: str) -> None:
    assert program.stdin is not None
    program.stdin.write(f"{line}\n")
    program.stdin.flush()


def _line(program: subprocess.Popen[str]) -> str:
    assert program.stdout is not None
    return program.stdout.readline().strip()


def limit(runs: int) -> list[Row]:
    """The first rate with a loss, and CPU time; each size once, whatever `runs` says."""
    rows = []
    with ros_domain():
        for size in BEGIN_HZ:
            limit_hz, bare_s = _bare_limit(size)
            part, ours_s = _recorded_part(size, limit_hz)
            name = _name(size)
            detail = f"{limit_hz:.0f}/s, {limit_hz * size / 1e6:.1f} MB/s; up to {PARTS[-1]} tried"
            what = f"bag record, {name}: first loss against bare subscriptions"
            rows.append(Row(what, part, "x", LEAST_PART, detail, at_least=True))
            write_s = _write_s(size)
            detail = f"{ours_s * 1e6:.1f} us each, bare {bare_s * 1e6:.1f}, dd {write_s * 1e6:.1f}"
            what = f"bag record, {name}: CPU against bare subscriptions and dd"
            rows.append(Row(what, ours_s / (bare_s + write_s), "x", CPU_LIMIT, detail))
    return rows


def _name(size: int) -> str:
    if size < 1 << 10:
        return f"{size} B"
    return f"{size >> 10} kB" if size < 1 << 20 else f"{size >> 20} MB"


def _bare_limit(size: int) -> tuple[float, float]:
    """The limit of bare subscriptions, and their CPU time for a message at half of it."""
    program = _talking("-c", BARE)
    sources = Sources(size, program)
    rate_hz = float(BEGIN_HZ[size])
    for number in range(STEPS):
        step = sources.publish(rate_hz)
        _say(program, "")
        got = json.loads(_line(program))[number]
        if got < step.sent or step.reached_hz < BEHIND * rate_hz:
            break
        rate_hz *= FACTOR
    half = sources.publish(PARTS[0] * rate_hz)
    sources.close()
    program.send_signal(2)
    program.communicate()
    return rate_hz, half.cpu_s / half.sent


def _recorded_part(size: int, limit_hz: float) -> tuple[float, float]:
    """The first of `PARTS` with a loss, or the last one, and CPU time for a message at half."""
    with scratch() as folder:
        words = ("-m", "launcher", "bag", "record", *TOPICS, "-o", str(folder / "bag"))
        program = _talking(*words, "--disable-keyboard-controls")
        sources = Sources(size, program)
        steps = [sources.publish(part * limit_hz) for part in PARTS]
        program.send_signal(2)
        program.communicate()
        sources.close()
        found = Counter(one.data[HEAD_BYTES] for one in Bag(str(folder / "bag")).messages())
    lossy = [
        part
        for number, (part, step) in enumerate(zip(PARTS, steps, strict=True))
        if found[number] < step.sent
    ]
    return min(lossy, default=PARTS[-1]), steps[0].cpu_s / steps[0].sent


def _write_s(size: int) -> float:
    """CPU time of `dd` for the bytes of a message."""
    blocks = 400
    with scratch() as folder:
        words = ["dd", "if=/dev/zero", f"of={folder / 'file'}", "bs=1M", f"count={blocks}"]
        return _used(words).cpu_s / (blocks << 20) * size


class Use(NamedTuple):
    """Wall and CPU time of a program, and its peak memory, which includes no pages of files."""

    wall_s: float
    cpu_s: float
    peak_mb: float


def _used(words: list[str]) -> Use:
    start, peak = time.monotonic(), 0.0
    program = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while True:
        pid, status, usage = os.wait4(program.pid, os.WNOHANG)
        if pid:
            break
        peak = max(peak, _own_mb(program.pid))
        time.sleep(0.005)
    program.returncode = os.waitstatus_to_exitcode(status)
    assert program.returncode == 0, words
    return Use(time.monotonic() - start, usage.ru_utime + usage.ru_stime, peak)


def _own_mb(pid: int) -> float:
    """Memory that is no file's, in MB."""
    with contextlib.suppress(OSError):
        for line in Path(f"/proc/{pid}/status").read_text().splitlines():
            if line.startswith("RssAnon:"):
                return int(line.split()[1]) / 1000
    return 0.0


def large(runs: int) -> list[Row]:
    """MB/s against `cat`, and the memory for ten times the bytes; once, whatever `runs` says."""
    rows = []
    with ros_domain():
        for storage in ("mcap", "sqlite3"):
            small, _ = _uses(storage, SMALL_MB)
            found, cat_s = _uses(storage, LARGE_MB)
            for verb, least in LEAST_SPEED.items():
                use = found[verb]
                speed = f"{LARGE_MB / use.wall_s:.0f} MB/s, cat {LARGE_MB / cat_s:.0f}"
                what = f"bag {verb}, 2 GB, {storage}"
                part = cat_s / use.wall_s
                rows.append(Row(f"{what}: against cat", part, "x", least, speed, at_least=True))
                growth = use.peak_mb / small[verb].peak_mb
                detail = f"{use.peak_mb:.1f} MB, {small[verb].peak_mb:.1f} for 200 MB"
                rows.append(Row(f"{what}: memory", growth, "x", MEMORY_LIMIT, detail))
    return rows


def _uses(storage: str, megabytes: int) -> tuple[dict[str, Use], float]:
    """Of each verb, and the seconds that `cat` takes."""
    with scratch() as folder:
        bag, copy = folder / "bag", folder / "copy"
        (_write_mcap if storage == "mcap" else _write_sqlite)(bag, megabytes)
        launcher = [sys.executable, "-m", "launcher", "bag"]
        found = {
            "info": _used([*launcher, "info", str(bag)]),
            "convert": _used([*launcher, "convert", str(bag), "-o", str(copy)]),
        }
        shutil.rmtree(copy)
        found["play"] = _used([*launcher, "play", str(bag), "-r", "1000"])
        files = [str(path) for path in bag.iterdir()]
        return found, min(_used(["cat", *files]).wall_s for _ in range(3))


def _messages(megabytes: int) -> Iterator[Message]:
    """Of random bytes, 1 us apart, so that they are played as fast as it goes."""
    noise = os.urandom(500 * LARGE_MESSAGE)
    size = LARGE_MESSAGE - HEAD_BYTES
    head = bytes([0, 1, 0, 0]) + bytes(8) + size.to_bytes(4, "little")
    for number in range(megabytes * 1_000_000 // LARGE_MESSAGE):
        start = number % 500 * LARGE_MESSAGE
        at_ns = 10**18 + number * 1000
        yield Message("/a", at_ns, at_ns, number + 1, head + noise[start : start + size])


def _write_mcap(folder: Path, megabytes: int) -> None:
    writer = BagWriter(str(folder), Storage())
    definition = Definition(text=DEFINITION)
    writer.add_topic(Topic(name="/a", type=TYPE, definition=definition))
    for message in _messages(megabytes):
        writer.write(message)
    writer.close()


def _write_sqlite(folder: Path, megabytes: int) -> None:
    """As rosbag2 does, without metadata."""
    folder.mkdir()
    database = sqlite3.connect(folder / "bag_0.db3")
    database.executescript(SCHEMA)
    database.execute("INSERT INTO topics VALUES (1, '/a', ?, 'cdr', '', '')", (TYPE,))
    row = (1, TYPE, "ros2msg", DEFINITION, "")
    database.execute("INSERT INTO message_definitions VALUES (?, ?, ?, ?, ?)", row)
    database.executemany(
        "INSERT INTO messages (topic_id, timestamp, data) VALUES (1, ?, ?)",
        ((message.log_ns, message.data) for message in _messages(megabytes)),
    )
    database.commit()
    database.close()
