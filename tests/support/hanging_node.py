"""A node that hangs on request: `python -m tests.support.hanging_node FOLDER [--no-services]`.

The file FOLDER/NAME says how it hangs, as soon as it exists: `sleep` until the file is gone; in a C
`call` that keeps the GIL; in a `deadlock` of two threads. With `--late` it hangs before it spins.
"""

from __future__ import annotations

import contextlib
import ctypes
import sys
import threading
import time
from pathlib import Path

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

PERIOD_S = 0.1


def sleep(request: Path) -> None:
    while request.exists():
        time.sleep(PERIOD_S)


def call(request: Path) -> None:
    lock, mutex = ctypes.PyDLL(None).pthread_mutex_lock, ctypes.create_string_buffer(64)
    lock(mutex)
    lock(mutex)  # no signal ends it


def deadlock(request: Path) -> None:
    first, second, both = threading.Lock(), threading.Lock(), threading.Barrier(2)

    def other() -> None:
        with second:
            both.wait()
            first.acquire()

    threading.Thread(target=other, name="other", daemon=True).start()
    with first:
        both.wait()
        second.acquire()


HOW = {"sleep": sleep, "call": call, "deadlock": deadlock}


def main() -> None:
    rclpy.init()
    node = Node("hanging", start_parameter_services="--no-services" not in sys.argv)
    request = Path(sys.argv[1]) / node.get_name()

    def tick() -> None:
        if request.exists():
            HOW[request.read_text()](request)

    node.create_timer(PERIOD_S, tick)
    print("ready", flush=True)
    if "--late" in sys.argv:
        sleep(request)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
