"""The delay of a line of a process on a host, from its write to the operator's screen."""

from __future__ import annotations

import subprocess
import sys
from functools import partial

from benchmarks.harness import Row, interleaved, median
from benchmarks.hosts.bench import (
    AGENT,
    JOURNAL,
    LOCAL,
    Bench,
    Job,
    bench,
    has_systemd_engine,
    process,
)
from benchmarks.latency import quantile, read_delays

SETTLE_S = 2.0  # the run has started, and samples memory for the first time
LINES = {LOCAL: 500, AGENT: 500, JOURNAL: 150}
PAUSE_S = {LOCAL: 0.004, AGENT: 0.004, JOURNAL: 0.023}
_LIMITS_MS = {AGENT: 5.0, JOURNAL: 300.0}
_CHILD = """
import os, time
time.sleep({settle})
for _ in range({lines}):
    time.sleep({pause})
    os.write(1, b"sent %d\\n" % time.monotonic_ns())
"""


def delay(runs: int) -> list[Row]:
    """The median by the agent and by the journal; all computers have the same clock."""
    with bench(robots=has_systemd_engine()) as one:
        hosts = {LOCAL: None, AGENT: one.everything_on(one.lab.host("bot1"), engine="ssh")}
        if has_systemd_engine():
            hosts[JOURNAL] = one.everything_on(one.lab.robot("bot2"), engine="systemd")
        jobs = {name: Job(one.launch_file([_child(name)]), path) for name, path in hosts.items()}
        found = interleaved(
            max(1, runs // 2), {name: partial(_delays_ns, one, name, jobs[name]) for name in jobs}
        )
    return [_row(found, name) for name in jobs if name != LOCAL]


def _child(name: str) -> str:
    code = _CHILD.format(settle=SETTLE_S, lines=LINES[name], pause=PAUSE_S[name])
    return process(sys.executable, "-I", "-S", "-c", code, name="child")


def _row(found: dict[str, list[list[int]]], name: str) -> Row:
    ours, slowest = ([quantile(d, q) / 1e6 for d in found[name]] for q in (0.5, 0.99))
    local = median([quantile(delays, 0.5) / 1e6 for delays in found[LOCAL]])
    spread = f"{min(ours):.3g}..{max(ours):.3g}"
    detail = f"medians {spread}, p99 {median(slowest):.3g} ms; local median {local:.2f} ms"
    return Row(f"delay of a line, {name}, median", median(ours), "ms", _LIMITS_MS[name], detail)


def _delays_ns(one: Bench, name: str, job: Job) -> list[int]:
    with one.running(job, subprocess.PIPE) as run:
        assert run.stdout is not None
        delays = read_delays(run.stdout.fileno())
    if len(delays) != LINES[name]:
        raise RuntimeError(f"{name} delivered {len(delays)} lines instead of {LINES[name]}")
    return delays
