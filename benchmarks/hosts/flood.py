"""Throughput of the agent: a million lines from eight processes on a host, each line checked."""

from __future__ import annotations

import contextlib
import itertools
import time
from functools import partial
from pathlib import Path

from benchmarks.contestant import wait_for_end
from benchmarks.harness import Row, interleaved, median, ratio
from benchmarks.hosts.bench import AGENT, LOCAL, NO_LOG_FILES, Bench, Job, bench, process
from benchmarks.throughput import CHILDREN, LINES_EACH, Flood, damaged, sources
from benchmarks.watch import ExecWatch

_ENVIRONMENTS: dict[str, dict[str, str]] = {"log files": {}, "no log files": NO_LOG_FILES}


def flood(runs: int) -> list[Row]:
    """Lines per second against the same processes here, with and without log files."""
    with bench() as one:
        files = sources(one.lab.folder)
        hosts = {LOCAL: None, AGENT: one.everything_on(one.lab.host("bot1"), engine="ssh")}
        measures = {
            f"{name}, {logs}": partial(_flood, one, path, files, env)
            for logs, env in _ENVIRONMENTS.items()
            for name, path in hosts.items()
        }
        found = interleaved(max(1, runs // 2), measures)
    return [*(_row(found, logs) for logs in _ENVIRONMENTS), _damage(found)]


def _row(found: dict[str, list[Flood]], logs: str) -> Row:
    ours, local = ([one.lines_per_s for one in found[f"{name}, {logs}"]] for name in (AGENT, LOCAL))
    ratios = [a / b for a, b in zip(ours, local, strict=True)]
    detail = (
        f"{median(ours) / 1e6:.2f} M lines/s, local {median(local) / 1e6:.2f}; "
        f"{min(ratios):.2f}..{max(ratios):.2f}"
    )
    what = f"1 M lines from a host, {logs}, against local"
    return Row(what, ratio(ours, local), "x", 0.5, detail, at_least=True)


def _damage(found: dict[str, list[Flood]]) -> Row:
    floods = list(itertools.chain.from_iterable(found.values()))
    lost = sum(one.damaged for one in floods)
    return Row("lines not whole, host", lost, "lines", 0, f"of {len(floods)} M, half of them local")


def _cat(program: Path, path: Path) -> str:
    """A path that is a word of its own would be taken for a file to send to the host."""
    return process("sh", "-c", f"exec {program} {path}", name=program.name)


def _flood(one: Bench, hosts: Path | None, files: list[Path], env: dict[str, str]) -> Flood:
    with contextlib.ExitStack() as stack:
        output = stack.enter_context(one.scratch()) / "output"
        store = stack.enter_context(one.programs("cat", len(files)))
        watch = stack.enter_context(ExecWatch(store))
        file = stack.enter_context(output.open("wb"))
        actions = [_cat(store / f"cat-{n}", path) for n, path in enumerate(files)]
        run = stack.enter_context(one.running(Job(one.launch_file(actions), hosts), file, **env))
        wait_for_end(run)
        seconds = time.monotonic() - watch.execs()[0]
        return Flood(CHILDREN * LINES_EACH / seconds, damaged(output, files))
