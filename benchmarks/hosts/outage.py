"""A link that is down for eight seconds: lines that are lost, and how late the others come."""

from __future__ import annotations

import itertools
import os
import re
import select
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

from benchmarks.harness import Row, median
from benchmarks.hosts.bench import (
    AGENT,
    JOURNAL,
    KEEP,
    Bench,
    Job,
    bench,
    has_systemd_engine,
    process,
)
from tests.support.hosts import Host, Robot

DOWN_S = 8.0
BEFORE_S = 2.0  # lines flow before the link is cut
AFTER_S = 6.0
START_S, LATEST_S = 60.0, 60.0
PAUSE_S = 0.005
LINES = int((BEFORE_S + DOWN_S + AFTER_S) / PAUSE_S)
# Each line has its number; "end" follows the last one.
_CHILD = f"""
import os, time
for number in range({LINES}):
    time.sleep({PAUSE_S})
    os.write(1, b"number %d\\n" % number)
os.write(1, b"end\\n")
time.sleep(1000)
"""
_NUMBER = re.compile(rb"\] number (\d+)\n")


class Outage(NamedTuple):
    """Lines that did not come, came twice or in another order; seconds to the next line."""

    lost: int
    disordered: int
    resumed_s: float


def outage(runs: int) -> list[Row]:
    """With the agent, whose policy is `keep`, and with the journal."""
    rows = []
    with bench(robots=has_systemd_engine()) as one:
        kinds: dict[str, tuple[Host | Robot, dict[str, str]]] = {
            AGENT: (one.lab.host("bot1"), {"engine": "ssh", **KEEP})
        }
        if has_systemd_engine():
            kinds[JOURNAL] = one.lab.robot("bot2"), {"engine": "systemd"}
        for name, (host, settings) in kinds.items():
            job = Job(_file(one), one.everything_on(host, **settings))
            measure = partial(_outage, one, job, host)
            rows.append(_row(name, [measure() for _ in range(max(1, runs // 3))]))
    return rows


def _file(one: Bench) -> Path:
    return one.launch_file([process(sys.executable, "-I", "-S", "-c", _CHILD, name="child")])


def _row(name: str, found: list[Outage]) -> Row:
    lost, disordered, resumed = zip(*found, strict=True)
    detail = (
        f"of {len(found) * LINES}, {sum(disordered)} twice or in another order; the first one "
        f"{median(list(resumed)):.2f} s after the link (at most {max(resumed):.2f})"
    )
    return Row(f"lines lost, link down {DOWN_S:g} s, {name}", sum(lost), "lines", 0, detail)


def _outage(one: Bench, job: Job, host: Host | Robot) -> Outage:
    with one.running(job, subprocess.PIPE) as run:
        assert run.stdout is not None
        lines = _Lines(run.stdout.fileno())
        lines.read(START_S, is_over=lambda: lines.numbers)
        lines.read(BEFORE_S)
        host.link_down()
        lines.read(DOWN_S)
        host.link_up()
        up_s, count = time.monotonic(), len(lines.numbers)
        lines.read(LATEST_S, is_over=lambda: len(lines.numbers) > count)
        resumed_s = time.monotonic() - up_s
        lines.read(LATEST_S, is_over=lambda: lines.has_ended)
    seen = lines.numbers
    disordered = sum(b <= a for a, b in itertools.pairwise(seen))
    return Outage(len(set(range(LINES)) - set(seen)), disordered, resumed_s)


class _Lines:
    """The numbers that the run has printed so far."""

    def __init__(self, fd: int) -> None:
        self._fd = fd
        self._rest = b""
        self.numbers: list[int] = []
        self.has_ended = False

    def read(self, seconds: float, is_over: Callable[[], object] = lambda: False) -> None:
        """Read for so long, or until that."""
        until = time.monotonic() + seconds
        while not is_over() and (left_s := until - time.monotonic()) > 0:
            if select.select([self._fd], [], [], left_s)[0]:
                self._take(os.read(self._fd, 65536))

    def _take(self, block: bytes) -> None:
        whole, newline, self._rest = (self._rest + block).rpartition(b"\n")
        text = whole + newline
        self.numbers += map(int, _NUMBER.findall(text))
        self.has_ended = self.has_ended or b"] end\n" in text or not block
