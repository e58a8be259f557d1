"""Evaluation of a large launch against ROS 2's, and growth up to 1,000 processes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from typing import NamedTuple

from benchmarks.contestant import REPOSITORY, end, python_environment, wait_for_end
from benchmarks.footprint import cpu_s, helpers, memory_mb
from benchmarks.harness import NotHereError, Row, interleaved, median, programs, ratio, scratch
from benchmarks.large.tree import write
from benchmarks.watch import ExecWatch

FEW, MANY = 250, 1000
AUTOWARE = 144
EXEC_S = 120.0
SETTLE_S = 5.0
_EVALUATION = Path(__file__).with_name("evaluation.py")


class Growth(NamedTuple):
    """CPU seconds of the evaluation, of the launcher until all is started, and of `ps`.

    `exec_s` is from the command to the last exec, `stop_s` from Ctrl-C to the end. Memory is PSS
    with the watchdog.
    """

    evaluation_s: float
    exec_s: float
    start_s: float
    ps_s: float
    stop_s: float
    memory_mb: float


def large(runs: int) -> list[Row]:
    """The rows; that about ROS 2 is left out where its packages cannot be imported."""
    rows: list[Row] = []
    try:
        rows.append(_against_ros2(max(1, runs // 3)))
    except NotHereError as error:
        print(f"not measured: {error}", file=sys.stderr, flush=True)
    found = [(_growth(FEW), _growth(MANY)) for _ in range(max(1, runs // 3))]
    whats = ("evaluation, CPU", "all exec'd", "start, CPU", "ps, CPU", "Ctrl-C", "memory")
    for number, what in enumerate(whats):
        few = [one[number] for one, _ in found]
        many = [one[number] for _, one in found]
        detail = f"{median(many):.3g}, {FEW}: {median(few):.3g} {'MB' if what == 'memory' else 's'}"
        rows.append(Row(f"{what}, {MANY} against {FEW}", ratio(many, few), "x", 5.0, detail))
    return rows


def _against_ros2(runs: int) -> Row:
    with scratch() as prefix:
        file = write(prefix, AUTOWARE, components=True)
        whats = ("launcher", "ros2")
        measures = {what: partial(_evaluation_s, what, file, prefix) for what in whats}
        _evaluation_s("ros2", file, prefix)
        found = interleaved(runs, measures)
    ours, theirs = (found[what] for what in whats)
    detail = f"CPU {median(ours):.2f} s, ROS 2's packages {median(theirs):.2f} s"
    what = f"evaluation of {AUTOWARE} nodes, 80 components, against ros2 launch"
    return Row(what, ratio(ours, theirs), "x", 0.5, detail)


def _environment(prefix: Path) -> dict[str, str]:
    before = os.environ.get("AMENT_PREFIX_PATH", sys.prefix)
    path = os.pathsep.join(filter(None, (str(REPOSITORY), os.environ.get("PYTHONPATH"))))
    variables = {"AMENT_PREFIX_PATH": f"{prefix}:{before}", "ROS_LOG_DIR": str(prefix / "log")}
    variables["TMPDIR"] = str(prefix)  # ROS 2 leaves its parameter files there
    return {**python_environment(), **variables, "PYTHONPATH": path}


def _evaluation_s(what: str, file: Path, prefix: Path) -> float:
    environment = _environment(prefix)
    if what == "ros2":  # the repository has a folder `launch`
        environment["PYTHONPATH"] = os.environ.get("PYTHONPATH", "")
    done = subprocess.run(
        [sys.executable, str(_EVALUATION), what, str(file)],
        env=environment,
        cwd=prefix,
        capture_output=True,
        text=True,
        check=what == "launcher",
    )
    found = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("found ")]
    if not found and "No module named" in done.stderr:
        raise NotHereError("launch, launch_ros and composition_interfaces are not importable")
    ((seconds, processes, _),) = found
    assert int(processes) >= AUTOWARE, done.stderr
    return float(seconds)


def _growth(count: int) -> Growth:
    with scratch() as prefix, programs("sleep", count) as store, ExecWatch(store) as watch:
        file = write(prefix, count, sorted(store.iterdir()), components=False)
        evaluation_s = _evaluation_s("launcher", file, prefix)
        command = [sys.executable, "-m", "launcher"]
        environment = _environment(prefix)
        begun = time.monotonic()
        with (prefix / "output").open("wb") as output:
            run = subprocess.Popen([*command, str(file)], env=environment, stdout=output)
        try:
            exec_s = watch.wait_for_execs(count, EXEC_S)[-1] - begun
            time.sleep(SETTLE_S)
            start_s = cpu_s(run.pid)
            memory = sum(memory_mb(pid)[1] for pid in (run.pid, *helpers(run.pid)))
            ps_s = _children_s([*command, "ps", "--run", str(run.pid)], environment)
            stopped = time.monotonic()
            run.send_signal(signal.SIGINT)
            wait_for_end(run)
            stop_s = time.monotonic() - stopped
        finally:
            end(run)
    return Growth(evaluation_s, exec_s, start_s, ps_s, stop_s, memory)


def _children_s(command: list[str], environment: dict[str, str]) -> float:
    """CPU seconds of a command."""
    before = os.times()
    subprocess.run(command, env=environment, stdout=subprocess.DEVNULL, check=True)
    after = os.times()
    used = after.children_user - before.children_user
    return used + after.children_system - before.children_system
