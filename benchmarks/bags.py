"""Recording and playing bags, and the flight recorder.

`record`: 5 topics at 1000 Hz with 1 kB, and one at 30 Hz with 1 MB, RELIABLE; what `bag record`
loses, and its CPU time against that of a bare rclpy program that subscribes raw and throws away.
`play`: how far from their times messages are published, at 1000 a second.
`flight`: what nodes and the launcher spend with and without `--record`.
"""

from __future__ import annotations

import json
import os
import shutil
import statistics
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

from benchmarks.footprint import cpu_s
from benchmarks.harness import Row, interleaved, median, ratio, scratch
from benchmarks.ros.verbs import ros_domain
from launcher.bag.bag_model import Definition, Message, Topic
from launcher.bag.reader import Bag
from launcher.bag.writer import BagWriter

SMALL, RATE_HZ, SMALL_BYTES = 5, 1000, 1000
BIG_HZ, BIG_BYTES = 30, 1_000_000
SECONDS = 10
MESSAGES = SMALL * RATE_HZ * SECONDS + BIG_HZ * SECONDS
CPU_LIMIT, CORE_LIMIT, PLAY_LIMIT_MS = 1.5, 1.0, 1.0
PLAYED = 5000
FLIGHT_S, SETTLED_S = 18, 4

PUBLISHER = f"""
import os, time, rclpy
from rclpy.duration import Duration
from rclpy.serialization import serialize_message
from std_msgs.msg import String, UInt8MultiArray
rclpy.init()
node = rclpy.create_node("source")
small = [node.create_publisher(String, f"/small_{{n}}", 1000) for n in range({SMALL})]
big = node.create_publisher(UInt8MultiArray, "/big", 100)
text = serialize_message(String(data="x" * {SMALL_BYTES}))
blob = serialize_message(UInt8MultiArray(data=os.urandom({BIG_BYTES})))
while any(one.get_subscription_count() < 1 for one in (*small, big)):
    time.sleep(0.05)
time.sleep(1.0)  # the subscriptions have to discover the publishers, too
start, sent = time.monotonic(), 0
for turn in range({RATE_HZ * SECONDS}):
    for one in small:
        one.publish(text)
    if turn * {BIG_HZ} // {RATE_HZ} >= sent:
        big.publish(blob)
        sent += 1
    time.sleep(max(0.0, start + (turn + 1) / {RATE_HZ} - time.monotonic()))
for one in (*small, big):
    one.wait_for_all_acked(Duration(seconds=10))
node.destroy_node()
rclpy.try_shutdown()
"""

BARE = f"""
import contextlib, rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import String, UInt8MultiArray
rclpy.init()
node = rclpy.create_node("bare")
count = 0
def take(message):
    global count
    count += 1
for number in range({SMALL}):
    node.create_subscription(String, f"/small_{{number}}", take, 1000, raw=True)
node.create_subscription(UInt8MultiArray, "/big", take, 100, raw=True)
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(node)
print(count, flush=True)
"""

LISTENER = f"""
import json, rclpy
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("listener")
times = []
def take(message, info):
    times.append(info["source_timestamp"])
node.create_subscription(String, "/steady", take, {PLAYED})
print("ready", flush=True)
while len(times) < {PLAYED}:
    rclpy.spin_once(node, timeout_sec=1.0)
print(json.dumps(times), flush=True)
"""

# A pair of nodes that print at the end what they have spent.
PAIR = """
import sys, time, threading, rclpy
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node(sys.argv[1])
if sys.argv[1] == "source":
    publisher, text = node.create_publisher(String, "/work", 10), String(data="x" * 1000)
    node.create_timer(0.01, lambda: publisher.publish(text))
else:
    node.create_subscription(String, "/work", lambda message: None, 10)
def spin(seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.1)
spin({settled})
before = time.process_time()
print("settled", flush=True)
spin({seconds})
print("spent", time.process_time() - before, flush=True)
"""
LAUNCH = """
import sys
from launch import LaunchDescription
from launch.actions import ExecuteProcess
def generate_launch_description():
    return LaunchDescription([
        ExecuteProcess(cmd=[sys.executable, {program!r}, name], name=name, output="screen")
        for name in ("source", "sink")
    ])
"""


def record(runs: int) -> list[Row]:
    """What is lost, and CPU time."""
    with ros_domain():
        found = interleaved(min(runs, 3), {"ours": _record, "bare": _bare})
    ours, bare = found["ours"], found["bare"]
    cpu = [cost for cost, _ in ours], [cost for cost, _ in bare]
    detail = f"{median(cpu[0]):.2f} s, bare {median(cpu[1]):.2f} s, in {SECONDS} s"
    lost = max(MESSAGES - count for _, count in ours)
    return [
        Row("bag record, messages lost", lost, "", 0, f"of {MESSAGES}"),
        Row("bag record, CPU against bare raw subscriptions", ratio(*cpu), "x", CPU_LIMIT, detail),
        Row("bag record, processor", median(cpu[0]) / SECONDS, "cores", CORE_LIMIT, detail),
    ]


def _record() -> tuple[float, int]:
    with scratch() as folder:
        words = ["-m", "launcher", "bag", "record", "--regex", "^/(small_.|big)$"]
        cpu_s, _ = _beside_publisher([*words, "-o", str(folder / "bag")])
        return cpu_s, Bag(str(folder / "bag")).extent.total


def _bare() -> tuple[float, int]:
    cpu_s, out = _beside_publisher(["-c", BARE])
    return cpu_s, int(out)


def _beside_publisher(words: list[str]) -> tuple[float, str]:
    """CPU time of a program that gets Ctrl-C when all was published, and what it printed."""
    program = subprocess.Popen(
        [sys.executable, *words], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    subprocess.run([sys.executable, "-c", PUBLISHER], check=True)
    program.send_signal(2)
    assert program.stdout is not None
    out = program.stdout.read()
    _, status, usage = os.wait4(program.pid, 0)
    program.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_utime + usage.ru_stime, out


def play(runs: int) -> list[Row]:
    """The median distance from the time at which a message is due."""
    with ros_domain(), scratch() as folder:
        _write_steady(folder / "bag")
        errors = [_play(folder / "bag") for _ in range(min(runs, 3))]
    worst = max(median(one) for one in errors)
    late = max(statistics.quantiles(one, n=100)[98] for one in errors)
    what = f"bag play, {RATE_HZ} messages/s, median distance from their times"
    return [Row(what, worst, "ms", PLAY_LIMIT_MS, f"99 % within {late:.1f} ms")]


def _write_steady(folder: Path) -> None:
    writer = BagWriter(str(folder))
    definition = Definition(text="string data\n")
    writer.add_topic(Topic(name="/steady", type="std_msgs/msg/String", definition=definition))
    start_ns = time.time_ns()
    data = b"\0\1\0\0" + (101).to_bytes(4, "little") + b"x" * 100 + b"\0"
    for number in range(PLAYED):
        at_ns = start_ns + number * 10**9 // RATE_HZ
        writer.write(Message("/steady", at_ns, at_ns, number + 1, data))
    writer.close()


def _play(bag: Path) -> list[float]:
    """Distances in ms; the first message is the zero of both clocks, corrected by the median."""
    listener = subprocess.Popen([sys.executable, "-c", LISTENER], stdout=subprocess.PIPE, text=True)
    assert listener.stdout is not None
    listener.stdout.readline()
    words = [sys.executable, "-m", "launcher", "bag", "play", str(bag)]
    subprocess.run(words, check=True, stderr=subprocess.DEVNULL)
    times = json.loads(listener.stdout.read())
    listener.wait()
    offsets = [at - number * 10**9 // RATE_HZ for number, at in enumerate(times)]
    middle = statistics.median(offsets)
    return [abs(offset - middle) / 1e6 for offset in offsets]


def flight(runs: int) -> list[Row]:
    """CPU time of two nodes and of the launcher, with and without the flight recorder.

    From some seconds after the start on: to start it takes the launcher 20 ms, once.
    """
    kinds = {"with": partial(_fly, "--record"), "without": _fly}
    with ros_domain():
        found = interleaved(min(runs, 5), kinds)
    rows = []
    for place, what in enumerate(("nodes", "launcher")):
        spent = [one[place] for one in found["with"]], [one[place] for one in found["without"]]
        detail = f"{median(spent[0]):.3f} s, without {median(spent[1]):.3f} s, in {FLIGHT_S} s"
        rows.append(Row(f"--record, CPU of the {what}", ratio(*spent), "x", 1.15, detail))
    return rows


def _fly(*words: str) -> tuple[float, float]:
    """CPU seconds of the nodes, and of the launcher."""
    with scratch() as folder:
        program, file = folder / "pair.py", folder / "pair.launch.py"
        program.write_text(PAIR.format(seconds=FLIGHT_S, settled=SETTLED_S))
        file.write_text(LAUNCH.format(program=str(program)))
        command = [sys.executable, "-m", "launcher", str(file), "--no-console", "--cold", *words]
        run = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert run.stdout is not None
        before = own = 0.0
        spent = []
        for line in run.stdout:
            if "settled" in line:
                before = cpu_s(run.pid)
            elif "spent" in line:
                spent.append(float(line.split()[-1]))
                own = cpu_s(run.pid) - before
        run.wait()
        shutil.rmtree(os.environ["ROS_LOG_DIR"], ignore_errors=True)
        return sum(spent), own
