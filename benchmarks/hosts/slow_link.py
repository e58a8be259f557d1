"""Lines of a node through a link of 10 Mbit/s: the agent against ssh alone."""

from __future__ import annotations

import subprocess
import time
from functools import partial
from pathlib import Path

from benchmarks.contestant import wait_for_end
from benchmarks.harness import Row, interleaved, median, ratio
from benchmarks.hosts.bench import Bench, Job, bench, process
from tests.support.hosts import Host
from tests.support.hosts.tool import run_tool

LINES = 120_000  # 12 MB
RATE = "10mbit"
_DONE = b"] done\n"
_LINE = "[INFO] [{seconds}.{nanos:09}] [robot_1.runner]: task {n} at ({x:.3f}, {y:.3f}): {ms} ms\n"


def slow_link(runs: int) -> list[Row]:
    """The time from the first line to the last one on the screen, against `ssh bot1 cat`."""
    with bench() as one:
        host = one.lab.host("bot1")
        _limit(host)
        source = one.path(".txt")
        source.write_text("".join(map(_line, range(LINES))), encoding="ascii")
        hosts = one.everything_on(host, engine="ssh")
        file = one.launch_file([process("sh", "-c", f"cat {source}; echo done", name="child")])
        measures = {
            "agent": partial(_agent_s, one, Job(file, hosts)),
            "ssh": partial(_ssh_s, one, host, source),
        }
        found = interleaved(max(1, runs // 3), measures)
    ours, bare = found["agent"], found["ssh"]
    detail = f"{median(ours):.2f} s for {LINES} lines, ssh alone {median(bare):.2f} s"
    return [Row(f"lines through {RATE}, against ssh cat", ratio(ours, bare), "x", 0.7, detail)]


def _limit(host: Host) -> None:
    """What the host sends is held back; the other way is free."""
    words = ("tc", "qdisc", "add", "dev", "eth0", "root", "tbf", "rate", RATE)
    limits = ("burst", "32kb", "latency", "200ms")
    run_tool("nsenter", f"--net={host.port.path}", *words, *limits)


def _line(number: int) -> str:
    """Of a node, with figures that differ in each line."""
    noise = number * 2654435761 % 2**32
    return _LINE.format(
        seconds=1_700_000_000 + number // 500,
        nanos=noise % 10**9,
        n=number,
        x=noise / 1e8,
        y=noise % 9973 / 100,
        ms=noise % 5000,
    )


def _agent_s(one: Bench, job: Job) -> float:
    """From the first line to the last; RuntimeError if one is missing."""
    with one.running(job, subprocess.PIPE) as run:
        assert run.stdout is not None
        begin_s, lines = 0.0, 0
        for line in run.stdout:
            if line.startswith(b"[child-1] "):
                begin_s = begin_s or time.monotonic()
                if line.endswith(_DONE):
                    break
                lines += 1
        seconds = time.monotonic() - begin_s
        wait_for_end(run)
    if lines != LINES:
        raise RuntimeError(f"{lines} lines instead of {LINES}")
    return seconds


def _ssh_s(one: Bench, host: Host, source: Path) -> float:
    words = one.lab.ssh(host, "cat", str(source))
    with one.operator(words, stdout=subprocess.PIPE) as run:
        assert run.stdout is not None
        run.stdout.readline()
        begin_s = time.monotonic()
        for _ in run.stdout:
            pass
        return time.monotonic() - begin_s
