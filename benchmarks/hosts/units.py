"""Robots with systemd: what each costs the operator's computer."""

from __future__ import annotations

import subprocess
from typing import NamedTuple

from benchmarks.harness import Row, median
from benchmarks.hosts.bench import Bench, Job, bench, process
from benchmarks.hosts.cost import Cost, idle_cost
from benchmarks.hosts.scale import EACH, HOSTS, IDLE_S, SETTLE_S
from benchmarks.hosts.screen import Screen
from tests.support.hosts import Robot

FEW, MANY = 1, 4
_CPU_PERCENT, _MEMORY_MB = 10.0, 150.0


class Growth(NamedTuple):
    """The operator's cost with few robots and with many."""

    few: Cost
    many: Cost

    def percent(self, robots: int) -> float:
        """As it would be with so many robots."""
        return _extended(self.few.percent, self.many.percent, robots)

    def mb(self, robots: int) -> float:
        return _extended(self.few.mb, self.many.mb, robots)


def units(runs: int) -> list[Row]:
    """CPU and memory, extended to as many robots as there are hosts in `scale`."""
    with bench(robots=True) as one:
        robots = [one.lab.robot(f"robot{number}") for number in range(MANY)]
        found = [
            Growth(_cost(one, robots[:FEW]), _cost(one, robots)) for _ in range(max(1, runs // 3))
        ]
    what = f"{HOSTS} robots with systemd, from {FEW} and {MANY}: operator's"
    percents, sizes = [one.percent(HOSTS) for one in found], [one.mb(HOSTS) for one in found]
    parts = [median(list(column)) for column in zip(*(one.many for one in found), strict=True)]
    cpu = f"of {MANY}: launcher {parts[0]:.1f}, ssh {parts[2]:.1f}"
    memory = f"of {MANY}: launcher {parts[3]:.0f}, ssh {parts[5]:.0f}"
    return [
        Row(f"{what} CPU", median(percents), "%", _CPU_PERCENT, f"{_spread(percents)}; {cpu}"),
        Row(f"{what} memory", median(sizes), "MB", _MEMORY_MB, f"{_spread(sizes)}; {memory}"),
    ]


def _cost(one: Bench, robots: list[Robot]) -> Cost:
    names = {f"idle{n}": robots[n // EACH] for n in range(len(robots) * EACH)}
    file = one.launch_file([process("sleep", "100000", name=name) for name in names])
    places = {f"process:{name}": robot.name for name, robot in names.items()}
    hosts = one.hosts_file({robot: {"engine": "systemd"} for robot in robots}, places)
    with one.running(Job(file, hosts), subprocess.PIPE) as run:
        Screen(run).await_lines("process started with pid", len(names))
        return idle_cost(run.pid, SETTLE_S, IDLE_S)


def _extended(few: float, many: float, robots: int) -> float:
    return few + (many - few) / (MANY - FEW) * (robots - FEW)


def _spread(values: list[float]) -> str:
    return f"{min(values):.3g}..{max(values):.3g}"
