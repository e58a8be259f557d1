"""Time to the first answer of verbs that talk to nodes, against bare rclpy programs.

Six participants: a node that publishes 50 times a second and answers requests, and five more. The
bare programs wait for a first message, or for a service and its answer, as the verbs do; they know
topic, type and service beforehand, while the verbs have to discover them.
"""

from __future__ import annotations

import contextlib
import subprocess
import sys
import time
from collections.abc import Iterator
from functools import partial

from benchmarks.harness import Row, interleaved, median, ratio
from benchmarks.ros.verbs import CROWD, VERB, cost_of, ros_domain

SETTLE_S = 6.0  # until they all know each other

SERVER = """
import contextlib, sys, threading, rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import Int32
rclpy.init()
node = rclpy.create_node("server")
node.declare_parameter("speed", 1.5)
publisher = node.create_publisher(Int32, "ticks", 10)
node.create_timer(0.02, lambda: publisher.publish(Int32()))
print("ready", flush=True)
threading.Thread(target=lambda: (sys.stdin.read(), rclpy.try_shutdown()), daemon=True).start()
with contextlib.suppress(ExternalShutdownException):
    rclpy.spin(node)
node.destroy_node()
"""

BARE_ECHO = """
import rclpy
from std_msgs.msg import Int32
rclpy.init()
node = rclpy.create_node("bare")
heard = []
node.create_subscription(Int32, "ticks", heard.append, 10)
while not heard:
    rclpy.spin_once(node, timeout_sec=0.1)
print(heard[0])
node.destroy_node()
rclpy.try_shutdown()
"""

BARE_GET = """
import rclpy
from rcl_interfaces.srv import GetParameters
rclpy.init()
node = rclpy.create_node("bare")
client = node.create_client(GetParameters, "/server/get_parameters")
client.wait_for_service()
future = client.call_async(GetParameters.Request(names=["speed"]))
rclpy.spin_until_future_complete(node, future)
print(future.result().values[0].double_value)
node.destroy_node()
rclpy.try_shutdown()
"""

_CALL = ("/server/list_parameters", "rcl_interfaces/srv/ListParameters", "{}")
PAIRS = {
    "topic echo --once": ((*VERB, "echo", "/ticks", "--once"), BARE_ECHO),
    "param get": (("-m", "launcher", "param", "get", "/server", "speed"), BARE_GET),
    "service call": (("-m", "launcher", "service", "call", *_CALL), BARE_GET),
}


def first_answers(runs: int) -> list[Row]:
    """Wall time from the command to its end, one answer between."""
    measures = {}
    for name, (words, program) in PAIRS.items():
        measures[name] = partial(_wall_s, *words)
        measures[f"bare {name}"] = partial(_wall_s, "-c", program)
    with ros_domain(), _company():
        found = interleaved(runs, measures)
    return [_row(name, found[name], found[f"bare {name}"]) for name in PAIRS]


def _row(name: str, ours: list[float], bare: list[float]) -> Row:
    detail = (
        f"launcher {median(ours):.2f} s (at most {max(ours):.2f}), "
        f"bare rclpy {median(bare):.2f} s (at most {max(bare):.2f})"
    )
    return Row(f"{name}, wall", ratio(ours, bare), "x", 1.0, detail)


def _wall_s(*words: str) -> float:
    cost = cost_of(*words)
    assert cost.out, f"no answer to {words}"
    return cost.wall_s


@contextlib.contextmanager
def _company() -> Iterator[None]:
    programs = [
        subprocess.Popen(
            [sys.executable, "-c", *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        for words in ((SERVER,), (CROWD, "0"))
    ]
    try:
        for program in programs:
            assert program.stdout is not None
            program.stdout.readline()
        time.sleep(SETTLE_S)
        yield
    finally:
        for program in programs:
            program.communicate()
