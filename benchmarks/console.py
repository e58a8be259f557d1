"""The console: its cost for the launcher, and the throughput to a terminal."""

from __future__ import annotations

import os
import pty
import select
import signal
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import NamedTuple

from benchmarks.contestant import REPOSITORY, RUN_TIMEOUT_S, python_environment
from benchmarks.footprint import cpu_s
from benchmarks.harness import Row, interleaved, median, ratio
from tests.support.children import children_with

STEADY_LINES_PER_S = 5_000
STEADY_S = 5.0
FLOOD_LINES = 400_000
READY = b"\x1b[?2004h"  # the console draws its prompt
PROMPT_S = 3.0  # a launcher without a console gets the same time
READ_BYTES = 256 * 1024
DOTS = b"." * 60  # after the number of each line

_CHILD = """import sys, time
total, rate = map(int, sys.argv[1:])
input()
begin, sent = time.monotonic(), 0
while sent < total:
    due = min(total, int((time.monotonic() - begin) * rate) + 1) if rate else total
    for sent in range(sent, due):
        sys.stdout.write(f'line {sent:08} ' + '.' * 60 + chr(10))
    sent = due
    sys.stdout.flush()
    time.sleep(0.01 if rate else 0)
print('done', flush=True)
input()
"""
_LAUNCH_FILE = """from launch import LaunchDescription
from launch.actions import ExecuteProcess


def generate_launch_description():
    return LaunchDescription([ExecuteProcess(cmd={command!r}, name="child", output="screen")])
"""


class Shown(NamedTuple):
    """CPU seconds of the launcher and of the console, wall seconds, damaged lines."""

    launcher_s: float
    console_s: float
    wall_s: float
    damaged: int


def console(runs: int) -> list[Row]:
    """5 000 lines a second, and the maximum, with and without a console."""
    steady = _measured(runs, int(STEADY_LINES_PER_S * STEADY_S), STEADY_LINES_PER_S)
    flood = _measured(max(1, runs // 2), FLOOD_LINES, 0)
    damaged = sum(one.damaged for found in (*steady.values(), *flood.values()) for one in found)
    return [_cost(steady), _speed(flood), Row("lines not whole, console", damaged, "lines", 0, "")]


def _measured(runs: int, lines: int, rate: int) -> dict[str, list[Shown]]:
    names = {"with": (), "without": ("--no-console",)}
    return interleaved(
        runs, {name: partial(_show, lines, rate, words) for name, words in names.items()}
    )


def _cost(found: dict[str, list[Shown]]) -> Row:
    ours, bare = ([one.launcher_s for one in found[name]] for name in ("with", "without"))
    shares = [100 * median(values) / STEADY_S for values in (ours, bare)]
    consoles = 100 * median([one.console_s for one in found["with"]]) / STEADY_S
    detail = f"{shares[0]:.1f} % of a core, without {shares[1]:.1f} %; the console {consoles:.1f} %"
    return Row("launcher's CPU, 5 000 lines/s, console", ratio(ours, bare), "x", 1.2, detail)


def _speed(found: dict[str, list[Shown]]) -> Row:
    ours, bare = ([FLOOD_LINES / one.wall_s for one in found[n]] for n in ("with", "without"))
    detail = f"{median(ours) / 1e3:.0f} k lines/s, without {median(bare) / 1e3:.0f} k"
    return Row("lines/s to a terminal, console", ratio(ours, bare), "x", 0.8, detail, at_least=True)


def _show(lines: int, rate: int, words: tuple[str, ...]) -> Shown:
    with tempfile.TemporaryDirectory(prefix="launcher-bench-") as name:
        folder = Path(name)
        command = [sys.executable, "-c", _CHILD, str(lines), str(rate)]
        file = folder / "bench.launch.py"
        file.write_text(_LAUNCH_FILE.format(command=command), encoding="utf-8")
        env = {**python_environment(), "TERM": "xterm"}
        env |= {"XDG_STATE_HOME": str(folder), "XDG_RUNTIME_DIR": str(folder)}
        pid, fd = pty.fork()
        if pid == 0:
            os.chdir(REPOSITORY)
            command = [sys.executable, "-m", "launcher", "--no-log-files", str(file), *words]
            os.execve(sys.executable, command, env)
        try:
            return _watch(pid, fd, lines, env, has_console=not words)
        finally:
            os.kill(pid, signal.SIGINT)
            _read_to_end(fd)
            os.waitpid(pid, 0)
            os.close(fd)


def _watch(pid: int, fd: int, lines: int, env: dict[str, str], *, has_console: bool) -> Shown:
    console_pid = _when_settled(pid, fd, has_console=has_console)
    go = [sys.executable, "-m", "launcher", "send", "--run", str(pid), "child", "go"]
    subprocess.run(go, env=env, cwd=REPOSITORY, check=True, stdout=subprocess.DEVNULL)
    own = [pid, *([console_pid] if console_pid else [])]
    before = [cpu_s(one) for one in own]
    begin = time.monotonic()
    whole = _count(fd, lines)
    wall_s = time.monotonic() - begin
    used = [cpu_s(one) - b for one, b in zip(own, before, strict=True)]
    return Shown(used[0], used[1] if console_pid else 0.0, wall_s, lines - whole)


def _when_settled(pid: int, fd: int, *, has_console: bool) -> int | None:
    """Wait until start-up is over; the console's pid."""
    seen = b""
    deadline = time.monotonic() + PROMPT_S
    while time.monotonic() < deadline:
        if select.select([fd], [], [], 0.05)[0]:
            seen += os.read(fd, READ_BYTES)
    if (READY in seen) != has_console:
        raise RuntimeError(f"console expected: {has_console}; output: {seen!r}")
    consoles = children_with(pid, "launcher.control.console")
    return consoles[0].pid if consoles else None


def _count(fd: int, lines: int) -> int:
    """Read until the child is done; the number of lines that are whole and in order.

    The beginning of a line may be shown above the prompt before the line itself is.
    """
    whole, rest, expected = 0, b"", 0
    deadline = time.monotonic() + RUN_TIMEOUT_S
    while b" done\r\n" not in rest:
        if time.monotonic() > deadline:
            raise TimeoutError(f"received only {whole} of {lines} lines")
        *found, rest = (rest + os.read(fd, READ_BYTES)).split(b" line ")
        for text in (*found, rest) if b" done\r\n" in rest else found:
            if text.startswith(b"%08d %s\r\n" % (expected, DOTS)):
                whole, expected = whole + 1, expected + 1
            elif text[:8].isdigit() and int(text[:8]) > expected:
                expected = int(text[:8]) + 1  # one is missing
    return whole


def _read_to_end(fd: int) -> None:
    try:
        while os.read(fd, READ_BYTES):
            pass
    except OSError:  # EIO: all processes have closed it
        return
