"""The fleet over three hosts: until all nodes are in the graph, and until all have stopped."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

from benchmarks.contestant import wait_for_end
from benchmarks.harness import Row, interleaved, median, milliseconds
from benchmarks.hosts.bench import AGENT, LOCAL, Bench, Job, bench
from benchmarks.warm.domain import OBSERVER

AT_ONCE = frozenset({"dispatcher", "monitor", "robot_1", "robot_2"})
DELAYED = "robot_3"  # 5 s later, by a timer of the launch file
SETTLE_S = 1.0


class Times(NamedTuple):
    """Seconds from the command to the nodes without a delay, and to all; from Ctrl-C to the end."""

    first_s: float
    all_s: float
    stop_s: float


def fleet(runs: int) -> list[Row]:
    """Dispatcher and monitor here and a robot on each host, against all of it here."""
    with bench() as one:
        robots = {one.lab.host(f"bot{number}"): f"robot_{number}" for number in (1, 2, 3)}
        hosts = one.hosts_file(
            {host: {"engine": "ssh"} for host in robots},
            {robot: host.name for host, robot in robots.items()},
        )
        jobs = {LOCAL: Job("system"), AGENT: Job("system", hosts)}
        found = interleaved(runs, {name: partial(_times, one, job) for name, job in jobs.items()})
    return _rows(found[AGENT], found[LOCAL])


def _rows(ours: list[Times], local: list[Times]) -> list[Row]:
    """The best of each: discovery takes another 3 s in many runs, with hosts or without."""
    whats = ("in the graph, robot_3 not counted", "all in the graph, robot_3 5 s late")
    rows = []
    for column, what in enumerate(whats):
        values, bases = ([times[column] for times in found] for found in (ours, local))
        detail = f"{milliseconds(values)}, local {milliseconds(bases)}; of the best of each"
        best = min(values) / min(bases)
        rows.append(Row(f"fleet on 3 hosts: {what}", best, "x", 2.0, detail))
    stops = [times.stop_s for times in ours]
    detail = f"{milliseconds(stops)}, local {milliseconds([times.stop_s for times in local])}"
    return [*rows, Row("fleet on 3 hosts: stop", median(stops), "s", 3.0, detail)]


def _times(one: Bench, job: Job) -> Times:
    with _observer(one) as observer:
        begun = time.monotonic()
        with one.running(job, subprocess.DEVNULL) as run:
            moments = _moments(observer)
            time.sleep(SETTLE_S)
            stopped = time.monotonic()
            run.send_signal(signal.SIGINT)
            wait_for_end(run)
            stop_s = time.monotonic() - stopped
    first_s = max(moments[name] for name in AT_ONCE) - begun
    return Times(first_s, max(moments.values()) - begun, stop_s)


@contextlib.contextmanager
def _observer(one: Bench) -> Iterator[subprocess.Popen[bytes]]:
    """A node that prints when it has discovered which other one."""
    with one.operator([sys.executable, "-c", OBSERVER], stdout=subprocess.PIPE) as observer:
        try:
            assert observer.stdout is not None
            assert observer.stdout.readline() == b"ready\n"
            yield observer
        finally:
            observer.send_signal(signal.SIGINT)


def _moments(observer: subprocess.Popen[bytes]) -> dict[str, float]:
    """When each node of the fleet was seen; returns when all were."""
    assert observer.stdout is not None
    moments: dict[str, float] = {}
    while not moments.keys() >= {*AT_ONCE, DELAYED}:
        name, _, moment = observer.stdout.readline().decode().partition(" ")
        if name in {*AT_ONCE, DELAYED}:
            moments[name] = float(moment)
    return moments
