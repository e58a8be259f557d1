"""A hundred robots on this machine: whether all work, and how the run ends."""

from __future__ import annotations

import os
import re
import signal
import time
from typing import NamedTuple

import psutil

from benchmarks.contestant import REPOSITORY, wait_for_end
from benchmarks.footprint import memory_mb
from benchmarks.harness import Row
from benchmarks.warm.domain import COLD, WARM, Domain, Run
from launcher.posix.domain_lease import leased_domain
from launcher.run.monitor.shared_memory import FOLDER, held

ROBOTS = 100
TIMEOUT_S = 400.0
ARRIVAL_S = 3.0  # of the last assignments
_WORDS = (f"robots:={ROBOTS}", "output:=own_log", "--discovery", "server")


class Work(NamedTuple):
    """Seconds from the command on; CPU seconds and PSS of all processes when all had worked."""

    started_s: float
    done_s: float
    cpu_s: float
    pss_mb: float
    stop_s: float
    lost: int
    left: int


def hundred(runs: int) -> list[Row]:
    """One run warm, one cold: each takes minutes."""
    found = {how.strip("-"): _work(how) for how in (WARM, COLD)}
    rows = []
    for how, work in found.items():
        detail = (
            f"all started after {work.started_s:.0f} s, CPU {work.cpu_s:.0f} s, "
            f"{work.pss_mb:.0f} MB"
        )
        what = f"{ROBOTS} robots, {how}"
        rows += [
            Row(f"{what}: all have completed a task", work.done_s, "s", float("inf"), detail),
            Row(f"{what}: assignments that did not arrive", work.lost, "", 0, ""),
            Row(f"{what}: stop", work.stop_s, "s", 10, ""),
            Row(f"{what}: left in /dev/shm", work.left, "files", 0, ""),
        ]
    return rows


def _work(how: str) -> Work:
    with leased_domain() as number:
        before = _ports(number)  # of killed nodes of earlier programs
        work = _run(how, number)
        return work._replace(left=work.left + len(_ports(number) - before))


def _run(how: str, number: int) -> Work:
    text = (REPOSITORY / "launch" / "warehouse.launch.py").read_text()
    with Domain(number).running(text, *_WORDS, how) as run:
        started = _wait_for(run, r"silent, 0 not started; ") - run.begun_s
        done = _wait_for(run, r" 0 not started; .*fewest tasks: [1-9]") - run.begun_s
        _wait_for(run, rf"Dispatched .* {ROBOTS} of {ROBOTS} robots report")
        processes = psutil.Process(run.process.pid).children(recursive=True)
        pids = {one.pid for one in processes}
        cpu = sum(one.cpu_times().user + one.cpu_times().system for one in processes)
        pss = sum(memory_mb(pid)[1] for pid in pids)
        files = {name for name, pid in held().items() if pid in pids}
        lost = _lost(run)
        begun = time.monotonic()
        run.process.send_signal(signal.SIGINT)
        wait_for_end(run.process)
        stop = time.monotonic() - begun
        left = sum((FOLDER / name).exists() for name in files)
    return Work(started, done, cpu, pss, stop, lost, left)


def _wait_for(run: Run, pattern: str) -> float:
    """When a line of the screen had this."""
    run.wait_for(lambda: re.search(pattern, run.screen), pause_s=0.1, timeout_s=TIMEOUT_S)
    return time.monotonic()


def _lost(run: Run) -> int:
    """Assignments that no robot has logged, and that were not given back for another one."""
    account = re.findall(r"Dispatched (\d+) tasks: .* (\d+) given back", run.screen)
    assigned, given_back = map(int, account[-1])
    time.sleep(ARRIVAL_S)
    received = sum(
        log.read_text().count("Received task") for log in run.files("robot-*-stderr.log")
    )
    return max(0, assigned - given_back - received)


def _ports(domain: int) -> set[int]:
    """Of the domain, with a file in /dev/shm."""
    ports = range(7400 + 250 * domain, 7400 + 250 * (domain + 1))
    found = re.findall(r"fastrtps_port(\d+)$", "\n".join(os.listdir(FOLDER)), re.M)
    return {int(port) for port in found} & {*ports}
