"""Resource samples of fifty nodes once a second: CPU time, and the delay of lines."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from functools import partial
from typing import NamedTuple

import psutil

from benchmarks.contestant import LAUNCHER, PREFIXER, Contestant, Work
from benchmarks.footprint import cpu_s
from benchmarks.harness import Row, interleaved, median, scratch
from launcher.run.monitor.resources import Sampler

NODES = 50
IDLE = 20  # interpreters whose samples are compared with those of psutil
SETTLE_S = 12.0  # fifty interpreters start, and the memory of new processes is read twice
SECONDS = 10
PAUSE_S = 0.002  # between lines: some coincide with a sample

# The size of an idle rclpy node: 50 MB, a dozen threads, some files.
_NODE = """
import asyncio, json, logging, os, signal, threading
memory = bytearray(30 << 20)
files = [open(os.devnull) for _ in range(20)]
for _ in range(10):
    threading.Thread(target=threading.Event().wait, daemon=True).start()
signal.signal(signal.SIGINT, signal.SIG_DFL)
signal.pause()
"""
_WRITER = f"""
import os, time
time.sleep({SETTLE_S})
os.write(1, b"ready\\n")
until = time.monotonic() + {SECONDS}
while time.monotonic() < until:
    time.sleep({PAUSE_S})
    os.write(1, b"sent %d\\n" % time.monotonic_ns())
time.sleep(1000)
"""


class Seen(NamedTuple):
    """The slowest line of each second, and the launcher's share of a core without any lines."""

    slowest_ms: list[float]
    cpu_percent: float


def sampling(runs: int) -> list[Row]:
    """The slowest line of a second, and the launcher's CPU time without output."""
    turns = max(1, runs // 3)
    found = interleaved(turns, {c.name: partial(_seen, c) for c in (LAUNCHER, PREFIXER)})
    ours, theirs = (
        [delay for seen in found[c.name] for delay in seen.slowest_ms] for c in (LAUNCHER, PREFIXER)
    )
    detail = f"the worst of {len(ours)} {max(ours):.2f}; prefixer {median(theirs):.2f} ms"
    cpu = median([seen.cpu_percent for seen in found[LAUNCHER.name]])
    what = f"{NODES} nodes sampled at 1 Hz"
    ratio, ms = _against_psutil()
    return [
        Row(f"slowest line of a second, {what}", median(ours), "ms", 1.0, detail),
        Row(f"CPU, {what}", cpu, "%", 1.0, f"over {SECONDS} s without a line"),
        Row(
            f"CPU, {IDLE} samples, against psutil for all of it",
            ratio,
            "x",
            0.8,
            f"{ms:.1f} ms a round",
        ),
    ]


def _against_psutil() -> tuple[float, float]:
    """CPU time of a minute of samples against that of psutil for the same values, and ms a round.

    In turns, so that what slows the machine down slows down both.
    """
    command = [sys.executable, "-S", "-c", "import signal; signal.pause()"]
    children = [subprocess.Popen(command, start_new_session=True) for _ in range(IDLE)]
    sampler, processes = Sampler(), [psutil.Process(child.pid) for child in children]
    ours_s = theirs_s = 0.0
    for second in range(60):
        before_s = time.process_time()
        for pause_s in sampler.steps((child.pid for child in children), partial(float, second)):
            time.sleep(pause_s)
        between_s = time.process_time()
        for process in processes:
            process.as_dict(["cpu_times", "memory_full_info", "num_threads", "num_fds"])
        ours_s += between_s - before_s
        theirs_s += time.process_time() - between_s
    for child in children:
        child.kill()
        child.wait()
    return ours_s / theirs_s, 1000 * ours_s / 60


def _seen(contestant: Contestant) -> Seen:
    commands = [[sys.executable, "-S", "-c", _NODE]] * NODES
    commands.append([sys.executable, "-I", "-S", "-c", _WRITER])
    with (
        scratch() as folder,
        contestant.running(Work(folder, commands), subprocess.PIPE) as process,
    ):
        assert process.stdout is not None
        fd = process.stdout.fileno()
        while b"ready" not in os.read(fd, 65536):
            pass
        slowest = _slowest_ms(fd)
        before_s = cpu_s(process.pid)
        time.sleep(SECONDS)
        used_s = cpu_s(process.pid) - before_s
    return Seen(slowest, 100 * used_s / SECONDS)


def _slowest_ms(fd: int) -> list[float]:
    """The longest delay of a line in each second."""
    slowest = []
    for _ in range(SECONDS):
        delays_ns = [0]
        until = time.monotonic() + 0.99
        while time.monotonic() < until:
            block, now = os.read(fd, 65536), time.monotonic_ns()
            sent = block.replace(b"\n", b" ").split(b"sent ")[1:]
            delays_ns += [now - int(word.split(b" ")[0]) for word in sent]
        slowest.append(max(delays_ns) / 1e6)
    return slowest
