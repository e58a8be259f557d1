"""CPU time and private memory of a launcher and its helpers."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from typing import NamedTuple

import psutil

from benchmarks.footprint import cpu_s

KINDS = ("launcher", "watchdog", "ssh")


class Cost(NamedTuple):
    """Shares of a core in percent while idle, and private memory (USS) in MB."""

    launcher_percent: float
    watchdog_percent: float
    ssh_percent: float
    launcher_mb: float
    watchdog_mb: float
    ssh_mb: float

    @property
    def percent(self) -> float:
        return self.launcher_percent + self.watchdog_percent + self.ssh_percent

    @property
    def mb(self) -> float:
        return self.launcher_mb + self.watchdog_mb + self.ssh_mb


def idle_cost(pid: int, settle_s: float, seconds: float) -> Cost:
    """Of the launcher with this pid and all that it has started here, over so many seconds."""
    time.sleep(settle_s)
    begun_s, before = time.monotonic(), _cpu(pid)
    time.sleep(seconds)
    after, passed_s = _cpu(pid), time.monotonic() - begun_s
    memory = dict.fromkeys(KINDS, 0.0)
    for one, kind in _processes(pid):
        memory[kind] += one.memory_full_info().uss / 2**20
    used = [after[kind] - before[kind] for kind in KINDS]
    return Cost(*(100 * one / passed_s for one in used), *(memory[kind] for kind in KINDS))


def _cpu(pid: int) -> dict[str, float]:
    """Seconds so far, by kind; a helper that exits in between takes its own with it."""
    used = dict.fromkeys(KINDS, 0.0)
    for one, kind in _processes(pid):
        with contextlib.suppress(OSError):
            used[kind] += cpu_s(one.pid)
    return used


def _processes(pid: int) -> Iterator[tuple[psutil.Process, str]]:
    """All processes of the tree, and what they are; those that have just ended are left out."""
    launcher = psutil.Process(pid)
    yield launcher, "launcher"
    for one in launcher.children(recursive=True):
        with contextlib.suppress(psutil.NoSuchProcess):
            yield one, "ssh" if one.name() == "ssh" else "watchdog"
