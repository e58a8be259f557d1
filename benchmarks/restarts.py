"""Restarts: a crash loop of five seconds, and the first restart of a run."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise
from typing import NamedTuple

from benchmarks.contestant import LAUNCHER, PREFIXER, Contestant, Work
from benchmarks.footprint import cpu_s
from benchmarks.harness import Row, interleaved, median, milliseconds, programs, scratch
from benchmarks.watch import ExecWatch, Seen
from tests.support.children import children_with

LOOP_S = 5.0
CALM_S = 1.5  # a run is idle when its first process dies
RESTARTS = 3  # of which the first is compared with the others
_PROGRAM = "sleep-0"


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
    gaps = _gaps(events)
    return Loop(median(gaps), (cpu_after - cpu_before) / len(gaps), len(gaps))


def first_restart(runs: int) -> list[Row]:
    """Death to next exec of the first process of a run that dies, and of the later ones."""
    return [
        _first(runs, "first restart of an idle run", _kills),
        _first(runs, "first restart, dead at once", _failures),
    ]


def _first(runs: int, what: str, gaps_of: Callable[[Contestant], list[float]]) -> Row:
    found = interleaved(runs, {c.name: partial(gaps_of, c) for c in (LAUNCHER, PREFIXER)})
    first, least = ([gaps[0] for gaps in found[c.name]] for c in (LAUNCHER, PREFIXER))
    later = [gap for gaps in found[LAUNCHER.name] for gap in gaps[1:]]
    others = f"later ones {milliseconds(later)}, prefixer {milliseconds(least)}"
    return Row(what, median(first) * 1000, "ms", 3.0, f"{milliseconds(first)}, {others}")


def _failures(contestant: Contestant) -> list[float]:
    """Seconds from each death to the next exec, for a process that fails at once."""
    with scratch() as folder, programs("false", 1) as store, ExecWatch(store) as watch:
        work = Work(folder, [[str(store / "false-0")]], respawn=True)
        with contestant.running(work, subprocess.DEVNULL):
            watch.wait_for_execs(RESTARTS + 1)
    return _gaps(watch.events)[:RESTARTS]


def _kills(contestant: Contestant) -> list[float]:
    """The same for a process that is killed from outside when nothing else happens."""
    with scratch() as folder, programs("sleep", 1) as store, ExecWatch(store) as watch:
        work = Work(folder, [[str(store / _PROGRAM), "1000"]], respawn=True)
        with contestant.running(work, subprocess.DEVNULL) as process:
            for count in range(1, RESTARTS + 1):
                watch.wait_for_execs(count)
                time.sleep(CALM_S)
                os.kill(_child(process.pid), signal.SIGSEGV)
            watch.wait_for_execs(RESTARTS + 1)
    return _gaps(watch.events)[:RESTARTS]


def _gaps(events: Sequence[Seen]) -> list[float]:
    return [b.when_s - a.when_s for a, b in pairwise(events) if a.died and not b.died]


def _child(pid: int) -> int:
    return children_with(pid, _PROGRAM)[0].pid
