"""Throughput of the agent: a million lines from eight processes on a host, each line checked."""

from __future__ import annotations

import contextlib
import itertools
import resource
import time
from functools import partial
from pathlib import Path
from typing import NamedTuple

from benchmarks.contestant import wait_for_end
from benchmarks.harness import Row, interleaved, median, ratio
from benchmarks.hosts.bench import AGENT, LOCAL, Bench, Job, bench, process
from benchmarks.throughput import CHILDREN, LINES_EACH, damaged, sources
from benchmarks.watch import ExecWatch

NO_LIMIT = float("inf")
_OPTIONS: dict[str, tuple[str, ...]] = {"log files": (), "no log files": ("--no-log-files",)}


class Flood(NamedTuple):
    """Lines per second from the first exec to the end of the run; damaged lines.

    `cpu_s` is the CPU time of the operator: launcher, and ssh or the processes themselves.
    """

    lines_per_s: float
    damaged: int
    cpu_s: float


def flood(runs: int) -> list[Row]:
    """Lines per second against the same processes here, with and without log files."""
    with bench() as one:
        files = sources(one.lab.folder)
        hosts = {LOCAL: None, AGENT: one.everything_on(one.lab.host("bot1"), engine="ssh")}
        measures = {
            f"{name}, {logs}": partial(_flood, one, path, files, words)
            for logs, words in _OPTIONS.items()
            for name, path in hosts.items()
        }
        found = interleaved(max(1, runs // 2), measures)
    rows = [
        _row(found, "log files", 0.5),
        _row(found, "no log files", 0.5),
        *(_cpu_row(found, logs) for logs in _OPTIONS),
    ]
    return [*rows, _damage(found)]


def _row(found: dict[str, list[Flood]], logs: str, limit: float) -> Row:
    ours, local = ([one.lines_per_s for one in found[f"{name}, {logs}"]] for name in (AGENT, LOCAL))
    ratios = [a / b for a, b in zip(ours, local, strict=True)]
    detail = (
        f"{median(ours) / 1e6:.2f} M lines/s, local {median(local) / 1e6:.2f}; "
        f"{min(ratios):.2f}..{max(ratios):.2f}"
    )
    what = f"1 M lines from a host, {logs}, against local"
    return Row(what, ratio(ours, local), "x", limit, detail, at_least=True)


def _cpu_row(found: dict[str, list[Flood]], logs: str) -> Row:
    ours, local = ([one.cpu_s for one in found[f"{name}, {logs}"]] for name in (AGENT, LOCAL))
    detail = f"launcher and ssh {median(ours):.2f} s, local {median(local):.2f} s"
    what = f"the same, {logs}: the operator's CPU"
    return Row(what, ratio(ours, local), "x", NO_LIMIT, detail)


def _damage(found: dict[str, list[Flood]]) -> Row:
    floods = list(itertools.chain.from_iterable(found.values()))
    lost = sum(one.damaged for one in floods)
    return Row("lines not whole, host", lost, "lines", 0, f"of {len(floods)} M, half of them local")


def _cat(program: Path, path: Path) -> str:
    """A path that is a separate word would be taken for a file to send to the host."""
    return process("sh", "-c", f"exec {program} {path}", name=program.name)


def _flood(one: Bench, hosts: Path | None, files: list[Path], words: tuple[str, ...]) -> Flood:
    with one.scratch() as folder, one.programs("cat", len(files)) as store:
        actions = (_cat(store / f"cat-{n}", path) for n, path in enumerate(files))
        job = Job(one.launch_file(actions), hosts, words)
        output, before_s = folder / "output", _children_s()
        with contextlib.ExitStack() as stack:
            watch = stack.enter_context(ExecWatch(store))
            file = stack.enter_context(output.open("wb"))
            wait_for_end(stack.enter_context(one.running(job, file)))
            seconds = time.monotonic() - watch.execs()[0]
        cpu_s = _children_s() - before_s
        return Flood(CHILDREN * LINES_EACH / seconds, damaged(output, files), cpu_s)


def _children_s() -> float:
    """CPU time of all descendants that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
