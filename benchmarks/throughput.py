"""Throughput: a million lines from eight children, each line checked."""

from __future__ import annotations

import contextlib
import itertools
import time
from functools import partial
from pathlib import Path
from typing import NamedTuple

from benchmarks.contestant import (
    LAUNCHER,
    LAUNCHER_WITHOUT_LOGS,
    PREFIXER,
    Contestant,
    Work,
    wait_for_end,
)
from benchmarks.footprint import cpu_s
from benchmarks.harness import Row, interleaved, median, milliseconds, programs, ratio, scratch
from benchmarks.watch import ExecWatch

CHILDREN = 8
LINES_EACH = 125_000
LINE_BYTES = 80  # with its newline


class Flood(NamedTuple):
    """Lines per second from the first exec to the end of the run; damaged lines; CPU time.

    The CPU time is that of the whole run, without the processes that it starts.
    """

    lines_per_s: float
    damaged: int
    cpu_s: float = 0.0


def pipes(runs: int) -> list[Row]:
    """Over pipes, with and without log files."""
    return _rows(runs, "pipes")


def ptys(runs: int) -> list[Row]:
    """Through pseudo-terminals, with and without log files."""
    return _rows(runs, "ptys")


def _rows(runs: int, through: str) -> list[Row]:
    contestants = (LAUNCHER, LAUNCHER_WITHOUT_LOGS, PREFIXER)
    with scratch() as folder:
        files = sources(folder)
        measures = {c.name: partial(_flood, c, files, pty=through == "ptys") for c in contestants}
        found = interleaved(runs, measures)
    return [
        _row(f"1 M lines, {through}, no log files", found, LAUNCHER_WITHOUT_LOGS, 0.7),
        _row(f"1 M lines, {through}, log files", found, LAUNCHER, 0.45),
        _cpu_row(f"CPU for 1 M lines, {through}, log files", found, 1.4),
        _damage(f"lines not whole, {through}", found),
    ]


def _row(what: str, found: dict[str, list[Flood]], contestant: Contestant, bar: float) -> Row:
    ours, best = (
        [flood.lines_per_s for flood in found[name]] for name in (contestant.name, PREFIXER.name)
    )
    detail = f"{median(ours) / 1e6:.2f} M lines/s, prefixer {median(best) / 1e6:.2f}"
    return Row(what, ratio(ours, best), "x", bar, detail, at_least=True)


def _cpu_row(what: str, found: dict[str, list[Flood]], bar: float) -> Row:
    ours, least = ([flood.cpu_s for flood in found[c.name]] for c in (LAUNCHER, PREFIXER))
    detail = f"launcher {milliseconds(ours)}, prefixer {milliseconds(least)}"
    return Row(what, ratio(ours, least), "x", bar, detail)


def _damage(what: str, found: dict[str, list[Flood]]) -> Row:
    floods = list(itertools.chain.from_iterable(found.values()))
    damaged = sum(flood.damaged for flood in floods)
    return Row(what, damaged, "lines", 0, f"of {len(floods)} M in all runs, the prefixer's too")


def _flood(contestant: Contestant, files: list[Path], *, pty: bool) -> Flood:
    with scratch() as folder, programs("cat", len(files)) as store, ExecWatch(store) as watch:
        commands = [[str(store / f"cat-{n}"), str(path)] for n, path in enumerate(files)]
        output = folder / "output"
        work = Work(folder, commands, pty=pty)
        with output.open("wb") as file, contestant.running(work, file) as process:
            used: list[float] = []
            wait_for_end(process, meanwhile=lambda pid: used.append(cpu_s(pid)))
            seconds = time.monotonic() - watch.execs()[0]
        return Flood(CHILDREN * LINES_EACH / seconds, damaged(output, files), used[0])


def sources(folder: Path) -> list[Path]:
    """Make the output of the children: each line has the number of the child and its own."""
    paths = [folder / f"source-{child}" for child in range(CHILDREN)]
    for child, path in enumerate(paths):
        path.write_bytes(b"".join(_line(child, number) for number in range(LINES_EACH)))
    return paths


def _line(child: int, number: int) -> bytes:
    head = b"child %d line %d " % (child, number)
    return head.ljust(LINE_BYTES - 1, b".") + b"\n"


def damaged(output: Path, files: list[Path]) -> int:
    """Lines that are missing, cut or mixed with others, and all after such a line of a child."""
    bad = 0
    with contextlib.ExitStack() as stack:
        expected = {
            b"[cat-%d-%d" % (n, n + 1): stack.enter_context(path.open("rb"))
            for n, path in enumerate(files)
        }
        for line in stack.enter_context(output.open("rb")):
            prefix, _, text = line.partition(b"] ")
            if prefix in expected:
                bad += text != expected[prefix].readline()
            else:
                bad += not line.startswith((b"[INFO] [", b"[WARNING] ["))
        bad += sum(1 for file in expected.values() for _ in file)
    return bad
