"""A crash loop: a process that exits at once is restarted at once, for five seconds."""

from __future__ import annotations

import subprocess
import time
from functools import partial
from itertools import pairwise
from typing import NamedTuple

from benchmarks.contestant import LAUNCHER, PREFIXER, Contestant, Work
from benchmarks.footprint import cpu_s
from benchmarks.harness import Row, interleaved, median, programs, scratch
from benchmarks.watch import ExecWatch

LOOP_S = 5.0


class Loop(NamedTuple):
    """Medians of one crash loop, in seconds, and the number of restarts."""

    gap_s: float
    cpu_s: float
    restarts: float


def respawn(runs: int) -> list[Row]:
    """Exit to next exec, and the launcher's CPU time per restart."""
    turns = max(1, runs // 2)
    found = interleaved(turns, {c.name: partial(_loop, c) for c in (LAUNCHER, PREFIXER)})
    ours, least = (
        Loop(*(median(list(column)) for column in zip(*found[c.name], strict=True)))
        for c in (LAUNCHER, PREFIXER)
    )
    return [
        Row(
            "respawn, death to next exec",
            ours.gap_s * 1000,
            "ms",
            1.0,
            f"prefixer {least.gap_s * 1000:.2f} ms; {ours.restarts:.0f} restarts",
        ),
        Row(
            "launcher CPU per respawn",
            ours.cpu_s * 1000,
            "ms",
            0.5,
            f"prefixer {least.cpu_s * 1000:.2f} ms",
        ),
    ]


def _loop(contestant: Contestant) -> Loop:
    with scratch() as folder, programs("false", 1) as store, ExecWatch(store) as watch:
        work = Work(folder, [[str(store / "false-0")]], respawn=True)
        with contestant.running(work, subprocess.DEVNULL) as process:
            watch.wait_for_execs(10)  # another row measures the start-up
            before, cpu_before = len(watch.events), cpu_s(process.pid)
            time.sleep(LOOP_S)
            events, cpu_after = watch.events[before:], cpu_s(process.pid)
    gaps = [b.when_s - a.when_s for a, b in pairwise(events) if a.died and not b.died]
    return Loop(median(gaps), (cpu_after - cpu_before) / len(gaps), len(gaps))
