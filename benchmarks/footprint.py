"""Memory and CPU time of a launcher with ten idle children."""

from __future__ import annotations

import subprocess
import time
from pathlib import Path
from typing import NamedTuple

import psutil

from benchmarks.contestant import LAUNCHER, PREFIXER, Contestant, Work
from benchmarks.harness import Row, median, programs, scratch
from benchmarks.watch import ExecWatch

CHILDREN = 10
SETTLE_S = 1.0
IDLE_S = 20.0


class Footprint(NamedTuple):
    """Memory in MB of the launcher's process, its watchdog's PSS, and CPU time while idle."""

    rss_mb: float
    pss_mb: float
    helpers_pss_mb: float
    cpu_percent: float


def footprint(runs: int) -> list[Row]:
    """Memory and CPU time, with the prefixer's memory for comparison."""
    ours = [_footprint(LAUNCHER, IDLE_S) for _ in range(max(1, runs // 3))]
    least = _footprint(PREFIXER, 0.0)
    rss, pss, others, cpu = (median(list(column)) for column in zip(*ours, strict=True))
    prefixer = f"prefixer {least.pss_mb:.1f}"
    return [
        Row("memory, 10 idle, RSS", rss, "MB", 28.0, f"prefixer {least.rss_mb:.1f} MB"),
        Row(
            "memory, 10 idle, PSS, with the watchdog",
            pss + others,
            "MB",
            18.0,
            f"launcher {pss:.1f} MB, {prefixer}",
        ),
        Row("CPU, 10 idle", cpu, "%", 0.5, f"over {IDLE_S:g} s, its watchdog included"),
    ]


def _footprint(contestant: Contestant, idle_s: float) -> Footprint:
    with scratch() as folder, programs("sleep", CHILDREN) as store, ExecWatch(store) as watch:
        commands = [[str(program), "1000"] for program in sorted(store.iterdir())]
        with contestant.running(Work(folder, commands), subprocess.DEVNULL) as process:
            watch.wait_for_execs(CHILDREN)
            time.sleep(SETTLE_S)
            own = [process.pid, *helpers(process.pid)]
            before = sum(map(cpu_s, own))
            time.sleep(idle_s)
            used = sum(map(cpu_s, own)) - before
            rss, pss = memory_mb(own[0])
            others = sum(memory_mb(pid)[1] for pid in own[1:])
    return Footprint(rss, pss, others, 100 * used / idle_s if idle_s else 0.0)


def helpers(pid: int) -> list[int]:
    """The launcher's own helper processes, without the programs under test."""
    children = psutil.Process(pid).children()
    return [child.pid for child in children if "sleep-" not in child.cmdline()[0]]


def memory_mb(pid: int) -> tuple[float, float]:
    """RSS and PSS of a process."""
    found = psutil.Process(pid).memory_full_info()
    return found.rss / 2**20, found.pss / 2**20


def cpu_s(pid: int) -> float:
    """CPU time of all threads of a process so far, without its children.

    psutil gives it in ticks of 10 ms, of which an idle launcher takes four in 20 s.
    """
    tasks = Path(f"/proc/{pid}/task").iterdir()
    return sum(int((task / "schedstat").read_text().split()[0]) for task in tasks) / 1e9
