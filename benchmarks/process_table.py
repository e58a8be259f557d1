"""What own readers of /proc save: the memory and the import of psutil, and its CPU time.

A row that is not met says that psutil would be good enough for its reader.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial

import psutil

from benchmarks.contestant import Contestant, Work, python_environment
from benchmarks.footprint import CHILDREN, memory_mb
from benchmarks.harness import Row, interleaved, median, milliseconds, ratio, scratch
from launcher.posix import proc
from tests.support.waiting import wait_until

BAR = 1.05  # of the figure without psutil
MOST = 1.0  # of the CPU time of psutil
PROCESSES = 40
ROUNDS = 30
SETTLE_S = 2.0
_MODULES = os.path.dirname(os.path.dirname(psutil.__file__))
_FILE = """from launch import LaunchDescription
from launch.actions import ExecuteProcess, OpaqueFunction, TimerAction


def act(context):
    {statement}
    open({done!r}, "w").close()


def generate_launch_description():
    children = [ExecuteProcess(cmd=["sleep", "1000"]) for _ in range({count})]
    # When it is idle, and has taken its first samples.
    act_late = TimerAction(period=2.0, actions=[OpaqueFunction(function=act)])
    return LaunchDescription([*children, act_late])
"""
Reader = Callable[[Sequence[int]], object]


def process_table(runs: int) -> list[Row]:
    """Memory of a run and start of Python with psutil, CPU time of the readers against it."""
    return [*_memory_rows(max(1, runs // 2)), _start_row(2 * runs), *_reader_rows(runs)]


# ---- memory of a run


def _memory_rows(turns: int) -> list[Row]:
    """Of the launcher, of its helpers with it, and of the ten processes with both."""
    statements = {"with": "import psutil", "without": "pass"}
    found = interleaved(turns, {name: partial(_memory, text) for name, text in statements.items()})
    rows = []
    for place, what in enumerate(("RSS", "PSS, with the watchdog", "PSS, with the processes")):
        values = [[one[place] for one in found[name]] for name in ("with", "without")]
        detail = f"{median(values[0]):.1f} MB, without {median(values[1]):.1f}"
        name = f"{CHILDREN} idle, with psutil, {what}"
        rows.append(Row(name, ratio(*values), "x", BAR, detail, at_least=True))
    return rows


def _memory(statement: str) -> tuple[float, float, float]:
    def command(work: Work) -> list[str]:
        file = work.folder / "bench.launch.py"
        text = _FILE.format(statement=statement, done=str(work.folder / "done"), count=CHILDREN)
        file.write_text(text, encoding="utf-8")
        return [sys.executable, "-m", "launcher", str(file)]

    def environment(work: Work) -> Mapping[str, str]:
        return {**python_environment(), "ROS_LOG_DIR": str(work.folder / "log")}

    contestant = Contestant("launcher", command, environment)
    with (
        scratch() as folder,
        contestant.running(Work(folder, ()), subprocess.DEVNULL) as launcher,
    ):
        wait_until((folder / "done").exists, "the launcher is idle")
        time.sleep(SETTLE_S)
        rss, own = memory_mb(launcher.pid)
        children = psutil.Process(launcher.pid).children()
        pss = {child.name() == "sleep": 0.0 for child in children}
        for child in children:
            pss[child.name() == "sleep"] += memory_mb(child.pid)[1]
    return rss, own + pss[False], own + pss[False] + pss[True]


# ---- start


def _start_row(runs: int) -> Row:
    """What a program waits for that imports it at once: a verb about a run, the watchdog."""
    found = interleaved(
        runs, {word: partial(_start_s, f"import {word}") for word in ("psutil", "sys")}
    )
    detail = f"{milliseconds(found['psutil'])}, without {milliseconds(found['sys'])}"
    times = ratio(found["psutil"], found["sys"])
    return Row("CPU to start Python, with psutil", times, "x", BAR, detail, at_least=True)


def _start_s(statement: str) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    code = f"import sys; sys.path.append({_MODULES!r}); {statement}"
    subprocess.run([sys.executable, "-I", "-S", "-c", code], env=python_environment(), check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


# ---- CPU time

# What is read -> our reader, and the same by psutil.
_READERS: dict[str, tuple[Reader, Reader]] = {
    "environments": (
        lambda pids: [proc.environment(pid) for pid in pids],
        lambda pids: [psutil.Process(pid).environ() for pid in pids],
    ),
    "command lines": (
        lambda pids: [proc.command_line(pid) for pid in pids],
        lambda pids: [psutil.Process(pid).cmdline() for pid in pids],
    ),
    "states": (
        lambda pids: [proc.state(pid) for pid in pids],
        lambda pids: [psutil.Process(pid).status() for pid in pids],
    ),
    "children": (
        lambda pids: proc.children(os.getpid()),
        lambda pids: psutil.Process().children(),
    ),
    "descendants": (
        lambda pids: proc.family([os.getpid()]),
        lambda pids: psutil.Process().children(recursive=True),
    ),
    "mapped files": (
        lambda pids: [proc.mapped(pid) for pid in pids],
        lambda pids: [psutil.Process(pid).memory_maps() for pid in pids],
    ),
    # The kernel walks all pages for both.
    "USS": (
        lambda pids: [proc.uss_bytes(pid) for pid in pids],
        lambda pids: [psutil.Process(pid).memory_full_info() for pid in pids],
    ),
    "UDP sockets": (
        lambda pids: list(proc.udp_sockets()),
        lambda pids: psutil.net_connections("udp"),
    ),
}


def _reader_rows(runs: int) -> Iterator[Row]:
    with _sleepers() as pids:
        for what, readers in _READERS.items():
            turns = interleaved(
                runs, {str(n): partial(_cpu_s, reader, pids) for n, reader in enumerate(readers)}
            )
            ours, theirs = turns.values()
            detail = f"{milliseconds(ours)}, psutil {milliseconds(theirs)}"
            name = f"CPU, {what} of {PROCESSES} processes, against psutil"
            yield Row(name, ratio(ours, theirs), "x", MOST, detail)


@contextmanager
def _sleepers() -> Iterator[list[int]]:
    command = [sys.executable, "-S", "-c", "import signal; print(flush=True); signal.pause()"]
    children = [subprocess.Popen(command, stdout=subprocess.PIPE) for _ in range(PROCESSES)]
    try:
        for child in children:
            assert child.stdout is not None
            child.stdout.readline()
        yield [child.pid for child in children]
    finally:
        for child in children:
            child.kill()
            child.communicate()


def _cpu_s(reader: Reader, pids: Sequence[int]) -> float:
    """CPU time of this process for one reading."""
    begun_s = time.process_time()
    for _ in range(ROUNDS):
        reader(pids)
    return (time.process_time() - begun_s) / ROUNDS
