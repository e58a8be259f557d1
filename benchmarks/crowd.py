"""Many idle processes under one launcher: what they cost, against ten."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from typing import NamedTuple

from benchmarks.contestant import LAUNCHER, REPOSITORY, Work, wait_for_end
from benchmarks.footprint import cpu_s, helpers, memory_mb
from benchmarks.harness import Row, median, programs, scratch
from benchmarks.watch import ExecWatch

FEW, MIDDLE, MANY = 10, 250, 500
SETTLE_S = 15.0  # the memory of new processes is read twice
IDLE_S = 20.0
EXEC_S = 120.0  # a busy machine may take long


class Crowd(NamedTuple):
    """Seconds from the command to the first and the last exec, of `ps`, and from Ctrl-C to the end.

    CPU time and memory are those of launcher and watchdog.
    """

    first_s: float
    last_s: float
    cpu_percent: float
    memory_mb: float
    ps_s: float
    stop_s: float


def crowd(runs: int) -> list[Row]:
    """500 idle processes, 250 and ten, in turn."""
    turns = max(1, runs // 3)
    found = [[_crowd(count) for count in (FEW, MIDDLE, MANY)] for _ in range(turns)]
    few, middle, many = (
        Crowd(*(median(list(column)) for column in zip(*crowds, strict=True)))
        for crowds in zip(*found, strict=True)
    )
    times = f"command to first exec {many.first_s * 1000:.0f} ms, {FEW}: {few.first_s * 1000:.0f}"
    return [
        Row(f"CPU, {MANY} idle", many.cpu_percent, "%", 2.0, f"{FEW}: {few.cpu_percent:.2f} %"),
        Row(
            f"memory, {MANY} idle, against {FEW}",
            many.memory_mb / few.memory_mb,
            "x",
            1.5,
            f"PSS with the watchdog {many.memory_mb:.1f} MB, {few.memory_mb:.1f}",
        ),
        _growth("all exec'd", middle.last_s, many.last_s, times),
        _growth("ps", middle.ps_s, many.ps_s),
        _growth("Ctrl-C", middle.stop_s, many.stop_s),
    ]


def _growth(what: str, middle_s: float, many_s: float, more: str = "") -> Row:
    """Twice as many may take twice as long, and a little more."""
    found = f"{many_s * 1000:.0f} ms, {MIDDLE}: {middle_s * 1000:.0f}"
    detail = f"{found}; {more}" if more else found
    return Row(f"{what}, {MANY} against {MIDDLE}", many_s / middle_s, "x", 2.5, detail)


def _crowd(count: int) -> Crowd:
    with scratch() as folder, programs("sleep", count) as store, ExecWatch(store) as watch:
        commands = [[str(program), "1000"] for program in sorted(store.iterdir())]
        work = Work(folder, commands)
        output = folder / "output"
        begun = time.monotonic()
        with output.open("wb") as file, LAUNCHER.running(work, file) as run:
            execs = watch.wait_for_execs(count, EXEC_S)
            time.sleep(SETTLE_S)
            own = [run.pid, *helpers(run.pid)]
            before = sum(map(cpu_s, own))
            time.sleep(IDLE_S)
            used = sum(map(cpu_s, own)) - before
            memory = sum(memory_mb(pid)[1] for pid in own)
            ps_s = median([_ps_s(run.pid, count) for _ in range(3)])
            stopped = time.monotonic()
            run.send_signal(signal.SIGINT)
            wait_for_end(run)
            stop_s = time.monotonic() - stopped
    return Crowd(execs[0] - begun, execs[-1] - begun, 100 * used / IDLE_S, memory, ps_s, stop_s)


def _ps_s(pid: int, count: int) -> float:
    begun = time.monotonic()
    command = [sys.executable, "-m", "launcher", "ps", "--run", str(pid)]
    done = subprocess.run(command, cwd=REPOSITORY, capture_output=True, check=True)
    assert done.stdout.count(b"sleep-") >= count
    return time.monotonic() - begun
