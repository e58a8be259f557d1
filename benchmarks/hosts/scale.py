"""Fifty hosts with four processes each: what they cost the operator's computer.

Each host is a set of namespaces with sshd and an agent; the processes only sleep. The operator
is the launcher with its watchdog and its ssh clients. A share of the hosts cannot be reached from
the start, or loses its link later.
"""

from __future__ import annotations

import re
import signal
import subprocess
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from benchmarks.contestant import wait_for_end
from benchmarks.harness import Row, median
from benchmarks.hosts.bench import KEEP, Bench, Job, bench, process
from benchmarks.hosts.cost import Cost, idle_cost
from benchmarks.hosts.screen import Line, Screen
from benchmarks.watch import ExecWatch
from tests.support.hosts import Host

HOSTS, EACH = 50, 4
CUT = 3  # hosts: 5 % of fifty, and a half more
SETTLE_S = 5.0
IDLE_S = 20.0
_CPU_PERCENT, _MEMORY_MB = 10.0, 150.0
_NONE = float("inf")


class Calm(NamedTuple):
    """A run without trouble: seconds from the command, the operator's cost, seconds to stop."""

    first_exec_s: float
    last_exec_s: float
    reported_s: float
    cost: Cost
    stop_s: float


class Trouble(NamedTuple):
    """A run with hosts whose links are cut: seconds until that is reported, and undone; costs."""

    detected_s: float
    cost: Cost
    returned_s: float
    stop_s: float
    is_named: bool
    false_alarms: int


class Refusal(NamedTuple):
    """A run with hosts that cannot be reached from the start."""

    seconds: float
    is_named: bool
    execs: int


def scale(runs: int) -> list[Row]:
    """Start, idle and stop of the fleet; the same while hosts cannot be reached."""
    turns = range(max(1, runs // 3))
    with bench() as one:
        hosts = [one.lab.host(f"host{number}") for number in range(HOSTS)]
        calm = [_calm(one, hosts) for _ in turns]
        trouble = [_trouble(one, hosts) for _ in turns]
        refusals = [_refusal(one, hosts) for _ in turns]
    return [*_calm_rows(calm), *_trouble_rows(trouble), *_refusal_rows(refusals)]


# ---- runs


@contextmanager
def _running(
    one: Bench, hosts: Sequence[Host]
) -> Iterator[tuple[float, subprocess.Popen[bytes], Screen, ExecWatch]]:
    """The time of the command, the run, its output, and when its processes were exec'd."""
    with one.programs("sleep", HOSTS * EACH) as store, ExecWatch(store) as watch:
        names = {f"sleep-{number}": hosts[number // EACH] for number in range(HOSTS * EACH)}
        file = one.launch_file(_sleep(store / name) for name in names)
        settings = {"engine": "ssh", **KEEP}
        places = {f"process:{name}": host.name for name, host in names.items()}
        path = one.hosts_file(dict.fromkeys(hosts, settings), places)
        begun = time.monotonic()
        with one.running(Job(file, path), subprocess.PIPE) as run:
            yield begun, run, Screen(run), watch


def _sleep(program: Path) -> str:
    """The launcher looks into a program that is a separate word, which is no exec."""
    return process("sh", "-c", f"exec {program} 100000", name=program.name)


def _calm(one: Bench, hosts: Sequence[Host]) -> Calm:
    with _running(one, hosts) as (begun, run, screen, watch):
        reported = screen.await_lines("process started with pid", HOSTS * EACH)
        cost = idle_cost(run.pid, SETTLE_S, IDLE_S)
        execs = watch.execs()
        stop_s = _stop_s(run)
    return Calm(execs[0] - begun, execs[-1] - begun, _last(reported) - begun, cost, stop_s)


def _trouble(one: Bench, hosts: Sequence[Host]) -> Trouble:
    names = "|".join(host.name for host in hosts[-CUT:])
    lost, back = rf"\b({names}) is unreachable", rf"\b({names}) is reachable again"
    with _running(one, hosts) as (_, run, screen, _):
        screen.await_lines("process started with pid", HOSTS * EACH)
        time.sleep(SETTLE_S)
        cut_s = _cut(hosts)
        detected_s = _last(screen.await_lines(lost, CUT, cut_s)) - cut_s
        cost = idle_cost(run.pid, SETTLE_S, IDLE_S)
        joined_s = _join(hosts)
        returned_s = _last(screen.await_lines(back, CUT, joined_s)) - joined_s
        cut_again_s = _cut(hosts)
        screen.await_lines(lost, CUT, cut_again_s)
        stop_s = _stop_s(run, returncode=1)
        is_named = _are_named(hosts, screen.await_lines("could not be reached", CUT))
        _join(hosts)
    alarms = (re.search(r"\b(host\d+) is unreachable", line.text) for line in screen.lines)
    false = sum(alarm is not None and not re.fullmatch(names, alarm[1]) for alarm in alarms)
    return Trouble(detected_s, cost, returned_s, stop_s, is_named, false)


def _refusal(one: Bench, hosts: Sequence[Host]) -> Refusal:
    _cut(hosts)
    try:
        with _running(one, hosts) as (begun, run, screen, watch):
            refused = screen.await_lines("cannot be used", CUT)
            wait_for_end(run)
            seconds = time.monotonic() - begun
            return Refusal(seconds, _are_named(hosts, refused), len(watch.execs()))
    finally:
        _join(hosts)


def _stop_s(run: subprocess.Popen[bytes], returncode: int = 0) -> float:
    begun = time.monotonic()
    run.send_signal(signal.SIGINT)
    if wait_for_end(run) != returncode:
        raise RuntimeError(f"exit code {run.returncode} instead of {returncode}")
    return time.monotonic() - begun


def _cut(hosts: Sequence[Host]) -> float:
    """Cut the links of the last hosts; when that was done."""
    for host in hosts[-CUT:]:
        host.link_down()
    return time.monotonic()


def _join(hosts: Sequence[Host]) -> float:
    for host in hosts[-CUT:]:
        host.link_up()
    return time.monotonic()


def _are_named(hosts: Sequence[Host], lines: Sequence[Line]) -> bool:
    text = "\n".join(line.text for line in lines)
    return all(host.name in text for host in hosts[-CUT:])


def _last(lines: Sequence[Line]) -> float:
    return lines[-1].when_s


# ---- rows


def _calm_rows(found: Sequence[Calm]) -> list[Row]:
    what = f"{HOSTS} hosts, {HOSTS * EACH} processes"
    start_s, spread = _seconds([one.reported_s for one in found])
    first = _seconds([one.first_exec_s for one in found])
    last = _seconds([one.last_exec_s for one in found])
    stops = [one.stop_s for one in found]
    return [
        *_cost_rows(what, [one.cost for one in found]),
        Row(f"{what}: start", start_s, "s", _NONE, f"{spread}; exec {first[0]:.2f} to {last[1]}"),
        Row(f"{what}: stop", median(stops), "s", _NONE, _seconds(stops)[1]),
    ]


def _trouble_rows(found: Sequence[Trouble]) -> list[Row]:
    what = f"{CUT} of {HOSTS} hosts cut"
    parts = {
        "detected": [one.detected_s for one in found],
        "caught up after the return": [one.returned_s for one in found],
        "stop without them": [one.stop_s for one in found],
    }
    rows = [
        Row(f"{what}: {part}", median(values), "s", _NONE, _seconds(values)[1])
        for part, values in parts.items()
    ]
    unnamed = sum(not one.is_named for one in found)
    alarms = sum(one.false_alarms for one in found)
    return [
        *_cost_rows(what, [one.cost for one in found]),
        *rows,
        Row(f"{what}: others called unreachable", alarms, "times", _NONE, f"in {len(found)} runs"),
        Row(f"{what}: stops that do not name them", unnamed, "runs", 0, f"of {len(found)}"),
    ]


def _refusal_rows(found: Sequence[Refusal]) -> list[Row]:
    what = f"{CUT} of {HOSTS} hosts never reached"
    values = [one.seconds for one in found]
    started = sum(one.execs for one in found)
    unnamed = sum(not one.is_named for one in found)
    return [
        Row(f"{what}: refused after", median(values), "s", _NONE, _seconds(values)[1]),
        Row(f"{what}: started nevertheless", started, "processes", 0, f"{unnamed} unnamed"),
    ]


def _cost_rows(what: str, costs: Sequence[Cost]) -> list[Row]:
    percents, sizes = [one.percent for one in costs], [one.mb for one in costs]
    spreads = [f"{min(values):.3g}..{max(values):.3g}" for values in (percents, sizes)]
    parts = [median(list(column)) for column in zip(*costs, strict=True)]
    cpu = f"{spreads[0]}; launcher {parts[0]:.1f}, watchdog {parts[1]:.1f}, ssh {parts[2]:.1f}"
    memory = f"{spreads[1]}; launcher {parts[3]:.0f}, watchdog {parts[4]:.0f}, ssh {parts[5]:.0f}"
    return [
        Row(f"{what}: operator's CPU", median(percents), "%", _CPU_PERCENT, cpu),
        Row(f"{what}: operator's memory", median(sizes), "MB", _MEMORY_MB, memory),
    ]


def _seconds(values: list[float]) -> tuple[float, str]:
    """The median, and a text with the spread."""
    return median(values), f"{median(values):.2f} s ({min(values):.2f}..{max(values):.2f})"
