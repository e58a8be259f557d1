"""Stopping: Ctrl-C with ten well-behaved children."""

from __future__ import annotations

import signal
import time
from functools import partial

from benchmarks.contestant import LAUNCHER, PREFIXER, Contestant, Work, wait_for_end
from benchmarks.harness import Row, interleaved, median, milliseconds, programs, scratch
from benchmarks.watch import ExecWatch

CHILDREN = 10
SETTLE_S = 0.5


def ctrl_c(runs: int) -> list[Row]:
    """SIGINT to the end of the launcher."""
    found = interleaved(runs, {c.name: partial(_stop_s, c) for c in (LAUNCHER, PREFIXER)})
    ours, least = found[LAUNCHER.name], found[PREFIXER.name]
    detail = f"{milliseconds(ours)}, prefixer {milliseconds(least)}"
    return [Row("Ctrl-C, 10 children", median(ours) * 1000, "ms", 50.0, detail)]


def _stop_s(contestant: Contestant) -> float:
    with scratch() as folder, programs("sleep", CHILDREN) as store, ExecWatch(store) as watch:
        commands = [[str(program), "1000"] for program in sorted(store.iterdir())]
        output = folder / "output"
        with output.open("wb") as file, contestant.running(Work(folder, commands), file) as run:
            watch.wait_for_execs(CHILDREN)
            time.sleep(SETTLE_S)
            begun = time.monotonic()
            run.send_signal(signal.SIGINT)
            wait_for_end(run)
            return time.monotonic() - begun
