"""--compose: several nodes of real programs in one process, on real DDS."""

from __future__ import annotations

import itertools
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.run.process.compose.composed import NODE, end, logged, plain, tasks
from tests.support.benches import ControlBench
from tests.support.controlled_run import ControlledRun
from tests.support.node_process import shared_memory_of
from tests.support.repository import REPOSITORY
from tests.support.waiting import rest_of, wait_until

pytest.importorskip("rclpy")


def test_robots_in_one_process_work_as_robots_of_their_own(bench: ControlBench):
    robot = f"{NODE}(package='group_gp1', output='screen', "
    actions = (
        f"{NODE}(package='group_gp1', executable='dispatcher', "
        "parameters=[{'dispatch_rate_hz': 5.0, 'robot_ids': ['robot_1', 'robot_2', 'robot_3']}]), "
        f"{robot} executable='robot_1', parameters=[{{'task_duration_s': 0.1}}]), "
        f"{robot} executable='robot_2', parameters=[{{'task_duration_s': 0.9}}]), "
        f"{robot} executable='robot_3')"
    )
    robots = {"robot_1-2": 0.1, "robot_2-3": 0.9, "robot_3-4": 0.3}
    with bench.launch(actions, "--compose", "robot_*") as run:
        for process in robots:
            done = f"task of {process}"
            wait_until(lambda p=process: "complete" in " ".join(tasks(run, p)), done)
        row = run.row("composed-1")
        files = shared_memory_of(row["pid"])
        assert len(run.ask("ps")["processes"]) == 2
        end(run)
    for process, duration_s in robots.items():
        assert min(_durations(run, process)) >= duration_s * 0.99
    assert min(_durations(run, "robot_1-2")) < min(_durations(run, "robot_2-3"))
    assert files
    assert [path for path in files if "_port" not in path.name and path.exists()] == []
    for process in robots:
        assert f"[INFO] [{process}]: node has finished cleanly in composed-1" in run.screen
    assert "[composed-1] [INFO]" not in run.screen  # each line has the prefix of its node


def _durations(run: ControlledRun, process: str) -> list[float]:
    found = re.findall(rf"\[{process}\] \[INFO\] \[([\d.]+)\] \[\w+\]: (Received|Task)", run.screen)
    pairs = itertools.pairwise(found)
    return [float(b[0]) - float(a[0]) for a, b in pairs if (a[1], b[1]) == ("Received", "Task")]


STYLES = ("usual", "careful", "threads", "loop", "client", "rate", "words")


def test_programs_of_any_style_run_as_they_are(bench: ControlBench):
    actions = ", ".join(
        plain(
            style,
            more=f", name={style!r}, namespace={'fleet' if style == 'careful' else ''!r}, "
            f"parameters=[{{'speed': {number}.5}}]",
        )
        for number, style in enumerate(STYLES, 1)
    )
    with bench.launch(actions, "--compose", "*") as run:
        for text in (
            "[words-7] words words words and 10\n",
            "[words-7] to stderr\n",
            "[INFO] [words-7]: node has finished cleanly in composed-1",
            "[threads-3] threads has a thread",
            "[client-5] client got True",
            "]: has another context",
            "[rate-6] rate has slept",
        ):
            run.wait_for(text)
        # Each has its own parameters, names and executor.
        for number, style in enumerate(STYLES[:4], 1):
            name = "fleet.careful" if style == "careful" else style
            own = f"heard /{name.replace('.', '/')} at {number}.5"
            wait_until(lambda p=f"{style}-{number}", n=name, t=own: t in logged(run, p, n), own)
        wait_until(
            lambda: "heard /usual at 3.5" in logged(run, "threads-3", "threads"), "a message"
        )
        end(run)
    # This one is called as the other by the words of the process.
    assert re.search(r"\[client-5\] .*\[client\]: has another context", run.screen)
    assert "[careful-2] careful was stopped" in run.screen
    assert "[threads-3] threads was stopped" in run.screen
    assert "[INFO] [usual-1]: node was stopped in composed-1 (SIGINT)" in run.screen
    assert "Traceback" not in run.screen


TALKATIVE = REPOSITORY / "tests/support" / "talkative_node.py"
NODES, LINES = 16, 40
STREAMS = {
    "pipe": "output='screen'",
    "two pipes": "output={'both': {'screen', 'own_log'}}",
    "terminal": "output='screen', emulate_tty=True",
}


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("streams", "times"), [("pipe", 1), *((streams, 3) for streams in STREAMS)]
)
def test_no_line_of_python_is_torn_and_no_end_is_lost(
    bench: ControlBench, streams: str, times: int
):
    actions = ", ".join(
        f"{NODE}(executable=sys.executable, arguments=[{str(TALKATIVE)!r}, 'n{n}', '{LINES}'], "
        f"exec_name='n{n}', {STREAMS[streams]})"
        for n in range(NODES)
    )
    for _ in range(times):
        with bench.launch(actions, "--compose", "*") as run:
            assert run.exit_code() == 0, run.screen
        log = (bench.folder / "log" / "latest" / "launch.log").read_text(errors="replace")
        for text in (run.screen, log):
            _check_talk(text.replace("\x1b[0m", ""))


def _check_talk(text: str) -> None:
    assert "\x1e" not in text, "a mark is seen"
    lines = [re.sub(r"^\d+\.\d{7} ", "", line) for line in text.splitlines()]
    places = {line: place for place, line in enumerate(lines)}
    logged = set(re.findall(r"<log (n\d+) (\d+)>$", text, re.MULTILINE))
    for n in range(NODES):
        name, own = f"n{n}", f"n{n}-{n + 1}"
        for number in range(LINES):
            assert f"[{own}] <print {name} {number} {'x' * (number * 997 % 9000)}>" in places
            assert f"[{own}] <error {name} {number}>" in places
            assert (
                name,
                str(number),
            ) in logged  # perhaps behind a piece
        end = f"[INFO] [{own}]: node has finished cleanly in composed-1"
        assert places[f"[{own}] last of {name}"] < places[end]
        assert lines.count(end) == 1
    assert len(re.findall("<piece ", text)) == NODES * LINES


def test_log_levels_are_those_of_each_node(bench: ControlBench):
    program = ["-m", "tests.support.logging_node"]
    nodes = ", ".join(
        f"{NODE}(executable=sys.executable, arguments={program!r}, exec_name={name!r}, "
        f"name={name!r}, cwd={str(REPOSITORY)!r}, output='screen')"
        for name in ("a", "b")
    )
    with bench.launch(nodes, "--compose", "*", "--log-level", "a=debug,b=error") as run:
        for process, level in (("a-1", "DEBUG"), ("b-2", "ERROR")):
            run.wait_for(f"[{process}] [{level}]")
        end(run)
    assert "[b-2] [INFO]" not in run.screen
    assert "[b-2] [DEBUG]" not in run.screen


@pytest.mark.thorough
def test_nodes_that_pkg_create_makes(bench: ControlBench, tmp_path: Path):
    env = {**bench.env, "TMPDIR": str(bench.runtime)}
    create = ["pkg", "create", "demo", "--node-name", "talker", "--node-name", "listener"]
    launcher = [sys.executable, "-m", "launcher"]
    subprocess.run([*launcher, *create], cwd=tmp_path, env=env, check=True, capture_output=True)
    run = subprocess.Popen(
        [*launcher, "demo/launch/demo.launch.py", "--compose", "*", "period_s:=0.1"],
        cwd=tmp_path,
        env=env,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert run.stdout is not None
    seen = ""
    for line in run.stdout:
        seen += line
        if {"[talker-1] [INFO]", "[listener-2] [INFO]"} <= set(
            re.findall(r"\[\S+\] \[INFO\]", seen)
        ):
            run.send_signal(signal.SIGINT)
            break
    seen += rest_of(run)[0]
    assert run.returncode == 0, seen
    for name in ("talker-1", "listener-2"):
        assert f"[INFO] [{name}]: node has finished cleanly in composed-1" in seen


@pytest.mark.thorough
def test_the_whole_system_in_one_process(bench: ControlBench):
    """The monitor has a MultiThreadedExecutor with callback groups of its own."""
    names = ("dispatcher", "monitor", "robot_1", "robot_2", "robot_3")
    actions = ", ".join(
        f"{NODE}(package='group_gp1', executable={name!r}, output='screen')" for name in names
    )
    with bench.launch(actions, "--compose", "*") as run:
        for number in (1, 2, 3):
            report = rf"\[monitor-2\].*robot_{number}: [1-9]\d* tasks"
            wait_until(lambda r=report: re.search(r, run.screen), f"tasks of robot {number}")
        assert len(run.ask("ps")["processes"]) == 1
        end(run)
    assert run.screen.count("node has finished cleanly in composed-1") == len(names)
