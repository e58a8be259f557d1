"""What it takes to watch a run: CPU of the launcher, the watcher and its probe, and memory.

`python -m benchmarks watching`. `python -m benchmarks.watched.cost RATE_HZ` is one of the runs.
"""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median

import psutil

from benchmarks.footprint import cpu_s
from benchmarks.harness import Row, interleaved, scratch
from benchmarks.ros.verbs import ros_domain
from benchmarks.web import web_run
from launcher.control.active_runs import ListedRun, wait_for_run
from tests.support.children import children_with
from tests.support.waiting import wait_until

TALKERS, EACH = 10, 10  # topics of each
TOPICS = TALKERS * EACH
RATES_HZ = (1, 10)
SETTLED_S, MEASURED_S = 20.0, 30.0  # the first: until everything is judged
START_S = 60.0
CORE, MEMORY_MB = 0.03, 100.0
_MODULES = {
    "watcher": "launcher.faults.watcher",
    "probe": "launcher.ros.probe",
    "evaluation": "launcher.smoke.expect.evaluation",
}

_TALKER = str(Path(__file__).with_name("talker.py"))
_LAUNCH = f"""
import sys
from launch import LaunchDescription
from launch_ros.actions import Node


def talker(name):
    return Node(
        executable=sys.executable,
        arguments=[{_TALKER!r}, "{EACH}", "RATE_HZ"],
        name=name,
        parameters=[{{"value": 1.0}}],
    )


def generate_launch_description():
    return LaunchDescription([talker(f"talker_{{number}}") for number in range({TALKERS})])
"""


def watching(runs: int) -> list[Row]:
    """100 topics, each with a rate and a latency; 10 nodes, each with a parameter."""
    return [row for rate_hz in RATES_HZ for row in _rows(rate_hz, min(runs, 3))]


def _rows(rate_hz: int, runs: int) -> list[Row]:
    memory_mb: list[float] = []
    kinds = {
        "with": lambda: _cost(rate_hz, memory_mb),
        "without": lambda: _cost(rate_hz, None),
    }
    with ros_domain():
        found = interleaved(runs, kinds)
    before = median([one["launcher"] for one in found["without"]])
    parts = {name: median([one[name] for one in found["with"]]) for name in found["with"][0]}
    parts["launcher"] -= before
    detail = ", ".join(f"{name} {share:.2%}" for name, share in parts.items())
    extra = median([sum(one.values()) for one in found["with"]]) - before
    what = f"watching {TOPICS} topics at {rate_hz} Hz"
    return [
        Row(f"{what}: CPU, without that of the launcher alone", extra, "cores", CORE, detail),
        Row(f"{what}: memory (USS) of watcher and probe", median(memory_mb), "MB", MEMORY_MB, ""),
    ]


def _cost(rate_hz: int, memory_mb: list[float] | None) -> dict[str, float]:
    """Parts of a core that each process takes; without `memory_mb` the run is not watched."""
    is_watched = memory_mb is not None
    with talkers(rate_hz, *(["--watchful"] if is_watched else [])) as launcher_pid:
        run = wait_for_run(launcher_pid, START_S)
        if is_watched:
            wait_until(lambda: len(helpers(launcher_pid)) > len(_MODULES), "a message is judged")
        time.sleep(SETTLED_S)
        pids = helpers(launcher_pid)
        before = {name: cpu_s(pid) for name, pid in pids.items()}
        time.sleep(MEASURED_S)
        found = {name: (cpu_s(pid) - before[name]) / MEASURED_S for name, pid in pids.items()}
        if memory_mb is not None:
            _see_health(run)
            own = [pid for name, pid in pids.items() if name != "launcher"]
            memory_mb.append(sum(psutil.Process(pid).memory_full_info().uss for pid in own) / 2**20)
        return found


@contextlib.contextmanager
def talkers(rate_hz: int, *words: str) -> Iterator[int]:
    """A run of them, with expectations beside its launch file; the pid of the launcher."""
    with scratch() as folder:
        file = folder / "talkers.launch.py"
        file.write_text(_LAUNCH.replace("RATE_HZ", str(rate_hz)), encoding="utf-8")
        (folder / "talkers.expect.yaml").write_text(_expectations(rate_hz), encoding="utf-8")
        with web_run(str(file), *words) as (launcher, _):
            yield launcher.pid


def _expectations(rate_hz: int) -> str:
    nodes = [f"/talker_{number}" for number in range(TALKERS)]
    topics = [f"{node}/topic_{number}" for node in nodes for number in range(EACH)]
    return "\n".join(
        [
            "expect:",
            *(f"  - {{node: {node}}}" for node in nodes),
            *(f"  - {{parameter: value, node: {node}, is: 1.0}}" for node in nodes),
            *(f"  - {{rate: {topic}, is: {rate_hz} Hz ± 20 %}}" for topic in topics),
            *(f"  - {{latency: {topic}, below: 1 s}}" for topic in topics),
            f"  - {{message: {topics[0]}, fields: {{point.x: {{max: 5}}}}, all: true}}",
            "  - {no_tracebacks: '*'}",
        ]
    )


def helpers(launcher_pid: int) -> dict[str, int]:
    """The launcher, and what it has started to watch the run."""
    pids = {"launcher": launcher_pid}
    for name, module in _MODULES.items():
        parent = pids["watcher"] if name != "watcher" else launcher_pid
        found = children_with(parent, module)
        if not found:
            break
        pids[name] = found[0].pid
    return pids


def _see_health(run: ListedRun) -> None:
    """A fault would be something else to do."""
    with run.connect() as connection:
        found = connection.ask("faults").result["faults"]
    assert not found, f"faults of a healthy run: {found}"


if __name__ == "__main__":
    with ros_domain():
        memory: list[float] = []
        shares = _cost(int(sys.argv[1]), memory)
        print({name: f"{share:.2%}" for name, share in shares.items()}, memory)
