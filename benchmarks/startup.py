"""Start-up: from the command to the first exec, and from there to the last one."""

from __future__ import annotations

import subprocess
import time
from functools import partial

from benchmarks.contestant import (
    LAUNCHER,
    SPAWN_LOOP,
    Contestant,
    Work,
    installed_command,
    python_s,
    shell_environment,
    wait_for_end,
)
from benchmarks.harness import Row, interleaved, median, milliseconds, programs, ratio, scratch
from benchmarks.watch import ExecWatch

FEW, MANY = 50, 200
SHELL_S = 0.05  # what is hardly noticed
ROS2_LAUNCH_S = 0.43  # `ros2 launch` on the machine of docs/inside/benchmarks.md


def first_exec(runs: int) -> list[Row]:
    """Command to first child exec'd, against the bare interpreter."""
    found = interleaved(
        runs,
        {"launcher": lambda: _exec_times(LAUNCHER, 1)[0], "bare": lambda: python_s("-c", "pass")},
    )
    ours, bare = found["launcher"], found["bare"]
    detail = f"launcher {milliseconds(ours)}, python -c pass {milliseconds(bare)}"
    return [
        Row("command to first exec", ratio(ours, bare), "x", 1.6, detail),
        Row(
            "the same, against ros2 launch",
            median(ours) / ROS2_LAUNCH_S,
            "x",
            1 / 3,
            f"against {ROS2_LAUNCH_S * 1000:.0f} ms, measured on another day",
        ),
    ]


def from_shell(runs: int) -> list[Row]:
    """The installed command as a shell starts it, to the first of ten; against `python -m`."""
    installed = installed_command()
    typed = Contestant(
        "command", lambda work: [installed, LAUNCHER.command(work)[-1]], _as_in_a_shell
    )
    module = Contestant("module", LAUNCHER.command, _as_in_a_shell)
    measures = {one.name: partial(_exec_times, one, 10) for one in (typed, module)}
    times = interleaved(runs, measures)
    ours, theirs = ([one[0] for one in times[name]] for name in measures)
    detail = f"{milliseconds(ours)}; {ratio(ours, theirs):.2f} x of python -m launcher"
    return [Row("command in a shell to the first of ten", median(ours), "s", SHELL_S, detail)]


def _as_in_a_shell(work: Work) -> dict[str, str]:
    return {**shell_environment(), "ROS_LOG_DIR": str(work.folder / "log")}


def many_execs(runs: int) -> list[Row]:
    """200 children, from the command and from the first exec to the last, against posix_spawn."""
    return _all_execs(runs, MANY, 2.0)


def fifty(runs: int) -> list[Row]:
    """The same with 50 children."""
    return _all_execs(runs, FEW, 1.8)


def _all_execs(runs: int, count: int, most: float) -> list[Row]:
    """`most` is the limit from the first exec on, where the loop has nothing but posix_spawn."""
    measures = {c.name: partial(_exec_times, c, count) for c in (LAUNCHER, SPAWN_LOOP)}
    found = interleaved(runs, measures)
    ours, loop = found[LAUNCHER.name], found[SPAWN_LOOP.name]
    spreads = [[_spread(times) for times in one] for one in (ours, loop)]
    lasts = [[times[-1] for times in one] for one in (ours, loop)]
    return [
        _against_loop(f"{count} children exec'd", spreads[0], spreads[1], most),
        _against_loop(f"command to all of {count}", lasts[0], lasts[1], 1.8),
    ]


def _against_loop(what: str, ours: list[float], loop: list[float], most: float) -> Row:
    detail = f"launcher {milliseconds(ours)}, loop {milliseconds(loop)}"
    return Row(what, ratio(ours, loop), "x", most, detail)


def _exec_times(contestant: Contestant, count: int) -> list[float]:
    """Seconds from the command to each exec, in order."""
    with scratch() as folder, programs("true", count) as store, ExecWatch(store) as watch:
        work = Work(folder, [[str(program)] for program in sorted(store.iterdir())])
        begun = time.monotonic()
        with contestant.running(work, subprocess.DEVNULL) as process:
            when = watch.wait_for_execs(count)
            if wait_for_end(process):
                raise RuntimeError(f"{contestant.name} failed")
    return [moment - begun for moment in when]


def _spread(times: list[float]) -> float:
    return times[-1] - times[0]
