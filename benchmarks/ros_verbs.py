"""How fast the ROS verbs are, against a bare rclpy program that does the same.

    python -m benchmarks.ros_verbs [list] [stream]

`list`: wall time and completeness of `topic list` on a graph of 20 nodes (participants of their
own, in four processes). The bare program does what a tool without a daemon does: a node, half a
second of waiting, a listing.
`stream`: a publisher sends 20000 small messages, RELIABLE, 5000 a second; how many arrive, and
what CPU time that costs. The bare program spins a subscription and counts.
"""

from __future__ import annotations

import contextlib
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass

from launcher.domain_lease import leased_domain

ROUNDS = 7
PROCESSES, NODES_EACH = 4, 5
NODES = PROCESSES * NODES_EACH
MESSAGES, RATE_HZ = 20000, 5000

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
time.sleep(0.5)  # the subscription has to know us as well
message, start = Int32(), time.monotonic()
for number in range({MESSAGES}):
    message.data = number
    publisher.publish(message)
    ahead = start + number / {RATE_HZ} - time.monotonic()
    if ahead > 0.002:
        time.sleep(ahead)
print(f"{{{MESSAGES} / (time.monotonic() - start):.0f}}", flush=True)
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
LIST = ("-m", "launcher", "topic", "list")


@dataclass(frozen=True, slots=True, kw_only=True)
class Cost:
    """Of one run of a program."""

    out: str
    wall_s: float
    cpu_s: float


def main(words: list[str]) -> int:
    """Run the benchmarks that are named, all if none is."""
    with leased_domain() as domain_id, tempfile.TemporaryDirectory() as log_dir:
        os.environ["ROS_DOMAIN_ID"] = str(domain_id)
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
        os.environ["ROS_LOG_DIR"] = log_dir
        if "list" in words or not words:
            with crowd():
                compare_lists()
        if "stream" in words or not words:
            compare_streams()
    return 0


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
    """The twenty nodes, once they have had time to find each other."""
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


def compare_lists() -> None:
    """Print medians, and how much of the graph each of them saw."""
    ours = [cost_of(*LIST) for _ in range(ROUNDS)]
    short = [cost_of(*LIST, "--spin-time", "0.25") for _ in range(ROUNDS)]
    bare = [cost_of("-c", BARE_LIST) for _ in range(ROUNDS)]
    print(f"topic list, {NODES} nodes, {ROUNDS} runs each")
    named = {"launcher": ours, "launcher, 0.25 s": short, "bare rclpy, 0.5 s": bare}
    for name, runs in named.items():
        seen = [sum(line.startswith("/t") for line in run.out.splitlines()) for run in runs]
        wall_s = statistics.median(run.wall_s for run in runs)
        complete = sum(count == NODES for count in seen)
        print(
            f"  {name:18} wall {wall_s:5.2f} s   cpu {_cpu(runs):5.2f} s   "
            f"complete {complete} of {ROUNDS} (topics seen: {min(seen)} to {max(seen)})"
        )
    ratio = statistics.median(r.wall_s for r in ours) / statistics.median(r.wall_s for r in bare)
    print(f"  wall, launcher / bare: {ratio:.2f}")


def _cpu(runs: list[Cost]) -> float:
    return statistics.median(run.cpu_s for run in runs)


def compare_streams() -> None:
    """Print what arrives, and CPU times against the bare subscription."""
    verb = ("-m", "launcher", "topic")
    rows = {
        "bare rclpy": _listen("-c", BARE_SUBSCRIBER.format(seconds=LISTEN_S)),
        "topic hz": _listen(*verb, "hz", "/fast", "--for", f"{LISTEN_S - 2:g}", "--json"),
        "topic echo --csv": _listen(
            *verb, "echo", "/fast", "std_msgs/msg/Int32", "--csv", "--timeout", "4",
            "--qos-reliability", "reliable",
        ),
        "topic echo": _listen(
            *verb, "echo", "/fast", "std_msgs/msg/Int32", "--timeout", "4",
            "--qos-reliability", "reliable",
        ),
    }  # fmt: skip
    print(f"stream, {MESSAGES} messages at {RATE_HZ} a second, RELIABLE")
    base = rows["bare rclpy"][0].cpu_s
    for name, (cost, rate) in rows.items():
        print(
            f"  {name:18} sent at {rate}/s   received {_received(cost.out):6}   "
            f"cpu {cost.cpu_s:5.2f} s   cpu / bare {cost.cpu_s / base:.2f}"
        )


def _listen(*words: str) -> tuple[Cost, str]:
    publisher = subprocess.Popen(
        [sys.executable, "-c", PUBLISHER], stdout=subprocess.PIPE, text=True
    )
    cost = cost_of(*words)
    out, _ = publisher.communicate()
    return cost, out.strip()


def _received(out: str) -> int:
    lines = out.splitlines()
    if '"messages":' in lines[-1]:
        import json

        return int(json.loads(lines[-1])["messages"])
    if len(lines) == 1:
        return int(lines[0])
    return sum(line != "---" for line in lines)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
