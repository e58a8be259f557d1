"""The speed of ROS verbs, against a bare rclpy program that does the same.

`topic_list`: wall time and completeness of `topic list` on a graph of 20 nodes (participants of
their own, in four processes). The bare program does what a tool without a daemon does: a node,
half a second of waiting, a listing.
`topic_stream`: a publisher sends 20000 small messages, RELIABLE, 5000 a second; how many arrive,
and what CPU time that costs. The bare program spins a subscription and counts.
"""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

from benchmarks.harness import Row, interleaved, median, ratio
from launcher.posix.domain_lease import leased_domain

PROCESSES, NODES_EACH = 4, 5
NODES = PROCESSES * NODES_EACH
MESSAGES, RATE_HZ = 20000, 5000
MAX_STREAMS = 3  # turns, of 40 s each

CROWD = f"""
import sys, rclpy
from rclpy.context import Context
from rclpy.node import Node
from std_msgs.msg import String
kept = []
for number in range({NODES_EACH}):
    context = Context()
    rclpy.init(context=context)
    node = Node(f"n{{sys.argv[1]}}_{{number}}", context=context)
    kept.append((node, node.create_publisher(String, f"t{{sys.argv[1]}}_{{number}}", 10)))
print("ready", flush=True)
sys.stdin.read()
for node, _ in kept:
    node.destroy_node()
    node.context.try_shutdown()
"""

BARE_LIST = """
import time, rclpy
rclpy.init()
node = rclpy.create_node("bare")
time.sleep(0.5)
for name, types in sorted(node.get_topic_names_and_types()):
    print(name)
node.destroy_node()
rclpy.try_shutdown()
"""

PUBLISHER = f"""
import time, rclpy
from rclpy.qos import QoSProfile
from std_msgs.msg import Int32
rclpy.init()
node = rclpy.create_node("fast")
publisher = node.create_publisher(Int32, "fast", QoSProfile(depth=5000))
while publisher.get_subscription_count() == 0:
    time.sleep(0.01)
time.sleep(0.5)  # the subscription has to discover the publisher, too
message, start = Int32(), time.monotonic()
for number in range({MESSAGES}):
    message.data = number
    publisher.publish(message)
    ahead = start + number / {RATE_HZ} - time.monotonic()
    if ahead > 0.002:
        time.sleep(ahead)
time.sleep(1.5)
node.destroy_node()
rclpy.try_shutdown()
"""

BARE_SUBSCRIBER = """
import time, rclpy
from rclpy.qos import QoSProfile
from std_msgs.msg import Int32
rclpy.init()
node = rclpy.create_node("bare")
count = 0
def take(message):
    global count
    count += 1
node.create_subscription(Int32, "fast", take, QoSProfile(depth=5000))
end = time.monotonic() + {seconds}
while time.monotonic() < end:
    rclpy.spin_once(node, timeout_sec=0.1)
print(count)
node.destroy_node()
rclpy.try_shutdown()
"""
LISTEN_S = 9.0
VERB = ("-m", "launcher", "topic")
LIST = (*VERB, "list")


@dataclass(frozen=True, slots=True, kw_only=True)
class Cost:
    """Cost of one run of a program."""

    out: str
    wall_s: float
    cpu_s: float


def topic_list(runs: int) -> list[Row]:
    """Wall time of `topic list` against the bare program's, and how much of the graph it saw."""
    words = {"launcher": LIST, "bare": ("-c", BARE_LIST)}
    with ros_domain(), crowd():
        found = interleaved(runs, {name: partial(cost_of, *w) for name, w in words.items()})
    ours, bare = found["launcher"], found["bare"]
    walls = [cost.wall_s for cost in ours], [cost.wall_s for cost in bare]
    detail = f"launcher {median(walls[0]):.2f} s, bare rclpy with 0.5 s {median(walls[1]):.2f} s"
    partly = [_seen(cost) for cost in bare]
    return [
        Row(f"topic list, {NODES} nodes, wall", ratio(*walls), "x", 0.5, detail),
        Row(
            f"topic list, {NODES} nodes, fewest seen",
            min(map(_seen, ours)),
            "nodes",
            NODES,
            f"bare rclpy {min(partly)} to {max(partly)}",
            at_least=True,
        ),
    ]


def _seen(cost: Cost) -> int:
    return sum(line.startswith("/t") for line in cost.out.splitlines())


@contextlib.contextmanager
def ros_domain() -> Iterator[None]:
    """Lease a ROS domain for the processes started in the block."""
    names = ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOG_DIR")
    before = {name: os.environ.get(name) for name in names}
    with leased_domain() as domain_id, tempfile.TemporaryDirectory() as log_dir:
        os.environ.update(zip(names, (str(domain_id), "LOCALHOST", log_dir), strict=True))
        try:
            yield
        finally:
            for name, value in before.items():
                if value is None:
                    del os.environ[name]
                else:
                    os.environ[name] = value


def cost_of(*words: str) -> Cost:
    """Run a Python program to its end."""
    with tempfile.TemporaryFile("w+") as out:
        start = time.monotonic()
        program = subprocess.Popen([sys.executable, *words], stdout=out)
        _, status, usage = os.wait4(program.pid, 0)
        wall_s = time.monotonic() - start
        program.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        return Cost(out=out.read(), wall_s=wall_s, cpu_s=usage.ru_utime + usage.ru_stime)


@contextlib.contextmanager
def crowd() -> Iterator[None]:
    """The twenty nodes, after they have had time to discover each other."""
    programs = [
        subprocess.Popen(
            [sys.executable, "-c", CROWD, str(number)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        for number in range(PROCESSES)
    ]
    try:
        for program in programs:
            assert program.stdout is not None
            program.stdout.readline()
        time.sleep(8.0)
        yield
    finally:
        for program in programs:
            program.communicate()


def topic_stream(runs: int) -> list[Row]:
    """Messages that arrive, and CPU time against the bare subscription's."""
    limit = f"{LISTEN_S - 2:g}"
    echo = (*VERB, "echo", "/fast", "std_msgs/msg/Int32", "--qos-reliability", "reliable")
    echo = (*echo, "--timeout", limit)
    words = {
        "bare": ("-c", BARE_SUBSCRIBER.format(seconds=LISTEN_S)),
        "topic hz": (*VERB, "hz", "/fast", "--for", limit, "--json"),
        "topic echo --csv": (*echo, "--csv"),
        "topic echo": echo,
    }
    with ros_domain():
        measures = {name: partial(_listen, *w) for name, w in words.items()}
        found = interleaved(min(runs, MAX_STREAMS), measures)
    base = [cost.cpu_s for cost in found.pop("bare")]
    return [row for name, costs in found.items() for row in _stream_rows(name, costs, base)]


def _stream_rows(name: str, costs: list[Cost], base: list[float]) -> list[Row]:
    cpu = [cost.cpu_s for cost in costs]
    detail = f"{name} {median(cpu):.2f} s, bare subscription {median(base):.2f} s"
    lost = max(MESSAGES - _received(cost.out) for cost in costs)
    return [
        Row(f"{name}, {RATE_HZ}/s, CPU", ratio(cpu, base), "x", 1.0, detail),
        Row(f"{name}, {RATE_HZ}/s, lost", lost, "messages", 0, f"of {MESSAGES}, RELIABLE"),
    ]


def _listen(*words: str) -> Cost:
    publisher = subprocess.Popen([sys.executable, "-c", PUBLISHER])
    cost = cost_of(*words)
    publisher.wait()
    return cost


def _received(out: str) -> int:
    lines = out.splitlines()
    if '"messages":' in lines[-1]:
        return int(json.loads(lines[-1])["messages"])
    if len(lines) == 1:
        return int(lines[0])
    return sum(line != "---" for line in lines)
