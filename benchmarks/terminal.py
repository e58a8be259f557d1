"""Throughput to a terminal: a million lines from eight children, each line checked."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import time
from functools import partial
from pathlib import Path

from benchmarks.contestant import LAUNCHER, PREFIXER, Contestant, Work, wait_for_end
from benchmarks.harness import Row, interleaved, median, programs, ratio, scratch
from benchmarks.throughput import CHILDREN, LINES_EACH, Flood, damaged, sources
from benchmarks.watch import ExecWatch

_COLOUR = re.compile(rb"\x1b\[[0-9;]*m")


def terminal(runs: int) -> list[Row]:
    """Eight flooding children on pipes, and a pseudo-terminal that `cat` reads."""
    with scratch() as folder:
        files = sources(folder)
        found = interleaved(runs, {c.name: partial(_flood, c, files) for c in (LAUNCHER, PREFIXER)})
    ours, best = ([one.lines_per_s for one in found[c.name]] for c in (LAUNCHER, PREFIXER))
    detail = f"{median(ours) / 1e6:.2f} M lines/s, prefixer {median(best) / 1e6:.2f}"
    broken = sum(one.damaged for flood in found.values() for one in flood)
    what = f"1 M lines of {CHILDREN} children to a terminal"
    return [
        Row(what, ratio(ours, best), "x", 0.85, detail, at_least=True),
        Row("lines not whole, terminal", broken, "lines", 0, "the prefixer's too"),
    ]


def _flood(contestant: Contestant, files: list[Path]) -> Flood:
    with scratch() as folder, programs("cat", len(files)) as store, ExecWatch(store) as watch:
        commands = [[str(store / f"cat-{n}"), str(path)] for n, path in enumerate(files)]
        ours, theirs = pty.openpty()
        output = folder / "output"
        with output.open("wb") as file:
            reader = subprocess.Popen(["cat"], stdin=ours, stdout=file, stderr=subprocess.DEVNULL)
        os.close(ours)
        with contestant.running(Work(folder, commands), theirs) as process:
            os.close(theirs)
            wait_for_end(process)
            wait_for_end(reader)  # after all that was written
            seconds = time.monotonic() - watch.execs()[0]
        output.write_bytes(_COLOUR.sub(b"", output.read_bytes().replace(b"\r\n", b"\n")))
        return Flood(CHILDREN * LINES_EACH / seconds, damaged(output, files))
