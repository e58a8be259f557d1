"""Latency of a line, from the write by a child to its arrival after the launcher."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from functools import partial

from benchmarks.contestant import LAUNCHER, PREFIXER, Contestant, Work
from benchmarks.harness import Row, interleaved, median, ratio, scratch

LINES = 500
SETTLE_S = 0.7  # the launcher is still starting after the first exec
PAUSE_S = 0.004  # between lines, so that all processes are idle again

_CHILD = f"""
import os, time
time.sleep({SETTLE_S})
for _ in range({LINES}):
    time.sleep({PAUSE_S})
    os.write(1, b"sent %d\\n" % time.monotonic_ns())
"""


def latency(runs: int) -> list[Row]:
    """Median and 99th percentile, against the prefixer's."""
    found = interleaved(runs, {c.name: partial(_delays_ns, c) for c in (LAUNCHER, PREFIXER)})
    return [
        _row("latency of a line, median", found, 0.5),
        _row("latency of a line, p99", found, 0.99),
    ]


def _row(what: str, found: dict[str, list[list[int]]], share: float) -> Row:
    ours, theirs = (
        [quantile(delays, share) / 1e6 for delays in found[c.name]] for c in (LAUNCHER, PREFIXER)
    )
    detail = f"launcher {median(ours):.3f} ms, prefixer {median(theirs):.3f} ms"
    return Row(what, ratio(ours, theirs), "x", 2.0, detail)


def quantile(values: list[int], share: float) -> float:
    """The value that this share of the others does not exceed."""
    return float(sorted(values)[round(share * (len(values) - 1))])


def _delays_ns(contestant: Contestant) -> list[int]:
    """One delay for each line."""
    with scratch() as folder:
        work = Work(folder, [[sys.executable, "-I", "-S", "-c", _CHILD]])
        with contestant.running(work, subprocess.PIPE) as process:
            assert process.stdout is not None
            delays = read_delays(process.stdout.fileno())
    if len(delays) != LINES:
        raise RuntimeError(f"{contestant.name} delivered {len(delays)} lines instead of {LINES}")
    return delays


def read_delays(fd: int) -> list[int]:
    """Of each line with the time at which it was sent, until the output ends."""
    delays = []
    while block := os.read(fd, 65536):
        now = time.monotonic_ns()
        words = block.replace(b"\n", b" ").split(b"sent ")[1:]
        delays += [now - int(word.split(b" ")[0]) for word in words]
    return delays
