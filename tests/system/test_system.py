"""The whole fleet under the launcher, as a person starts, watches and stops it."""

from __future__ import annotations

import json
import re
import signal
import subprocess
from pathlib import Path

import pytest

from launcher.packages.distribution import with_wheels
from launcher.run.monitor.shared_memory import FOLDER, held
from launcher.smoke.pytest_plugin import Launch, LaunchedSystem
from tests.support.repository import REPOSITORY
from tests.support.terminal import marked_processes
from tests.support.waiting import wait_until
from tests.system.conftest import LONG_STOP, LONG_STOP_WORDS, MARK, World

MAKE_RUN = ("make", "run", f"DISTRO={with_wheels()}")  # in the environment of the tests
FIRST_LINES = (
    "[dispatcher]: Assigned task pick_shelf_A3 to robot_1",
    "[robot_1]: Received task ",
    "[robot_1]: Task ",
    "[robot_2]: Received task ",
    "[robot_2]: Task ",
    "[robot_3]: Received task ",
    "[monitor]: Fleet report -- robot_1: ",
)


def shared_memory_of(world: World) -> set[Path]:
    """What the fleet holds in /dev/shm, without ports.

    Whoever sends to a node that has just gone makes its port anew, and a port is not freed while
    a node starts anywhere on the machine.
    """
    pids = {process.pid for process in marked_processes(MARK, world.mark).values()}
    names = {name for name, pid in held().items() if pid in pids}
    return {Path(FOLDER) / name for name in names if "_port" not in name}


def test_the_fleet_comes_up_and_ctrl_c_ends_it_cleanly_with_nothing_left(world: World):
    terminal = world.launcher("system")
    terminal.wait_for_all(*FIRST_LINES)
    files = shared_memory_of(world)
    assert len(files) >= 5 and all(path.exists() for path in files)
    terminal.ctrl_c()
    assert terminal.exit_code() == 0, terminal.text
    assert "failed to terminate" not in terminal.text
    assert "Traceback" not in terminal.text
    assert "process has died" not in terminal.text
    ends = re.findall(
        r"process (?:has finished cleanly|was stopped) \[pid \d+,? ?(\w*)", terminal.text
    )
    # One that Fast DDS does not let go ends by a timer: docs/guides/fleet.md.
    assert len(ends) == 5 and set(ends) <= {"", "SIGPROF", "SIGALRM"}, ends
    prefixes = set(re.findall(r"(\x1b\[38;5;\d+m)\[([a-z_0-9]+-\d)\]", terminal.raw))
    assert len(prefixes) == len({colour for colour, _ in prefixes}) == 5
    assert world.survivors() == []
    assert not [path for path in files if path.exists()]


@pytest.mark.thorough
def test_every_line_of_a_node_is_whole_and_behind_its_prefix(world: World):
    terminal = world.launcher("system", "enable_debug:=true", "--no-console")
    terminal.wait_for_all("[debug_logger]: /fleet/tasks: ", "[debug_logger]: /fleet/status: ")
    terminal.wait_for_all(*FIRST_LINES)
    terminal.ctrl_c()
    assert terminal.exit_code() == 0
    for line in terminal.text.replace("^C", "").splitlines():  # what the terminal echoes
        assert line.startswith("[") and "] " in line, line
        assert line.count("[INFO] [1") <= 1, f"two node lines in one: {line}"


@pytest.mark.thorough
@pytest.mark.parametrize("options", [(), ("--cold",)], ids=["warm", "cold"])
def test_robot_3_starts_5_s_after_the_dispatcher(world: World, options: tuple[str, ...]):
    terminal = world.launcher("system", "--no-console", *options)
    terminal.wait_for("[robot_3]: Late joiner: received ")
    terminal.wait_for(" assignments")
    terminal.ctrl_c()
    assert terminal.exit_code() == 0, terminal.text
    log = Path(world.env["ROS_LOG_DIR"]) / "latest" / "events.jsonl"
    events = [json.loads(line) for line in log.read_text().splitlines()]
    started = {one["process"]: one for one in events if one["event"] == "started"}
    late, first = started["robot_3-5"], started["dispatcher-1"]
    assert late["monotonic_s"] - first["monotonic_s"] >= 5.0
    # It gets all that was assigned before it was started, at most five.
    (received,) = re.findall(r"Late joiner: received (\d+) assignments", terminal.text)
    stamps = re.findall(r"\[INFO\] \[([\d.]+)\] \[dispatcher\]: Assigned task", terminal.text)
    before = sum(float(stamp) < late["wall_s"] for stamp in stamps)
    assert stamps
    assert min(before, 5) <= int(received) <= 5


@pytest.mark.thorough
def test_robot_2_is_left_out_on_request_and_can_join_from_a_second_terminal(
    world: World, launched_system: Launch
):
    fleet = launched_system("system", start_robot_2=False, **LONG_STOP)
    fleet.wait_for_log("monitor", "robot_2 has not reported in 5.0 s")
    assert fleet.logs("robot_2") == []

    robot = world.terminal(
        *world.command("run", "group_gp1", "robot_2"), env=dict(fleet.environment)
    )
    robot.wait_for("Received task ")
    fleet.wait_for_node("/robot_2")
    fleet.wait_for_log("monitor", "robot_2 is reporting")
    robot.ctrl_c()
    assert robot.exit_code() == 0
    assert "Traceback" not in robot.text
    fleet.wait_for_log("monitor", "robot_2 has not reported in 5.0 s", count=2)
    assert fleet.system.stop(150.0).returncode == 0


def test_a_misspelt_argument_is_refused_before_anything_starts(world: World):
    done = subprocess.run(
        world.command("system", "enable_debgu:=true"),
        env=world.env,
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 2
    assert "did you mean 'enable_debug'?" in done.stderr
    assert done.stdout == ""
    assert not Path(world.env["ROS_LOG_DIR"]).exists()


@pytest.mark.thorough
def test_sigterm_stops_everything_in_order(world: World):
    terminal = world.launcher("system")
    terminal.wait_for("[robot_1]: Received task ")
    terminal.signal(signal.SIGTERM)
    assert terminal.exit_code() == 0, terminal.text
    assert world.survivors() == []


@pytest.mark.thorough
def test_a_killed_launcher_leaves_no_process_behind(world: World):
    terminal = world.launcher("system")
    terminal.wait_for("[robot_1]: Received task ")
    assert len(world.survivors()) >= 5
    terminal.kill()
    wait_until(lambda: world.survivors() == [], "everything is gone")


def test_make_run_ends_with_exit_code_0_on_ctrl_c(world: World):
    arguments = f"ARGS=enable_debug:=true {' '.join(LONG_STOP_WORDS)}"
    terminal = world.terminal(*MAKE_RUN, arguments)
    terminal.wait_for_all("[debug_logger]: /fleet/tasks: ", timeout_s=120.0)
    terminal.ctrl_c()
    assert terminal.exit_code() == 0, terminal.text
    assert world.survivors() == []


@pytest.mark.thorough
def test_sigterm_to_make_run_without_a_terminal_ends_the_fleet(world: World):
    # As a container's or a CI's stop does it.
    make = subprocess.Popen(
        [*MAKE_RUN],
        env=world.env,
        cwd=REPOSITORY,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
    )
    assert make.stdout is not None
    assert any(b"[robot_1]: Received task" in line for line in make.stdout)
    make.terminate()
    wait_until(lambda: world.survivors() == [], "nothing is left")
    make.communicate(timeout=60)


@pytest.mark.thorough
def test_ctrl_z_stops_make_run_as_one_job_and_fg_goes_on(world: World):
    shell = world.terminal("bash", "--norc", "-i")
    shell.type(f"PS1='$ '; make run ARGS='{' '.join(LONG_STOP_WORDS)}'\n")
    shell.wait_for("[robot_1]: Received task")
    shell.type("\x1a")
    shell.wait_for("Stopped")
    shell.type("fg\n")
    shell.wait_for("[dispatcher]: Assigned task")
    shell.ctrl_c()
    shell.wait_for("process has finished cleanly")
    shell.wait_for("$ ")
    shell.type("echo exit code $?\n")
    shell.wait_for("exit code 0")
    assert world.survivors() == [line for line in world.survivors() if "bash" in line]


ENDS_AT_ONCE = """
import os, re, rclpy
rclpy.init()
node = rclpy.create_node("hasty")
with open("/proc/self/maps") as maps:
    print("has", *set(re.findall("/fast(?:rtps|dds)_[0-9a-f]{16}$", maps.read(), re.M)), flush=True)
os._exit(3)
"""
HASTY = """
import sys
from launch import LaunchDescription
from launch.actions import ExecuteProcess

def generate_launch_description():
    return LaunchDescription([
        ExecuteProcess(cmd=[sys.executable, "{folder}/hasty.py"], output="screen"),
        ExecuteProcess(cmd=["sleep", "{rest_s}"]),
    ])
"""


@pytest.mark.thorough
@pytest.mark.parametrize("way", ["--warm", "--cold"])
@pytest.mark.parametrize("rest_s", [0, 4])
def test_a_node_that_ends_without_a_clean_up_leaves_no_shared_memory(
    world: World, tmp_path: Path, way: str, rest_s: int
):
    """No other node frees it, and it has ended before the launcher has looked."""
    (tmp_path / "hasty.py").write_text(ENDS_AT_ONCE, encoding="utf-8")
    file = tmp_path / "hasty.launch.py"
    text = HASTY.replace("{folder}", str(tmp_path)).replace("{rest_s}", str(rest_s))
    file.write_text(text, encoding="utf-8")
    done = subprocess.run(
        world.command(str(file), way), env=world.env, capture_output=True, text=True, timeout=120
    )
    (segment,) = set(re.findall(r"has /(\w+)", done.stdout))
    assert not (Path(FOLDER) / segment).exists()


@pytest.mark.thorough
def test_a_killed_node_is_reported_and_its_shared_memory_freed(launched_system: Launch):
    fleet = launched_system("system", probe=False, **LONG_STOP)
    fleet.wait_for_log("robot_1", "Task ")
    # The launcher looks once a second what its processes hold; robot_3 comes later than that.
    fleet.wait_for_log("robot_3", "Received task ")
    segments = segments_of(fleet, "robot_1")
    assert segments
    fleet.kill("robot_1")
    fleet.wait_for_log("launch", r"process has died \[pid ")
    # By the launcher, or by the Fast DDS of a node that has read there: whichever looks first.
    wait_until(lambda: not [path for path in segments if path.exists()], "they are freed")
    ending = fleet.system.stop(150.0)
    assert (ending.returncode, ending.left_memory) == (130, ())
    assert any(
        "first unexpected exit: robot_1-3 (SIGKILL)" in line for line in fleet.logs("launch")
    )


ONE_NODE = """
import sys
from launch import LaunchDescription
from launch.actions import ExecuteProcess

def generate_launch_description():
    command = [sys.executable, "-m", "group_gp1.{name}"]
    return LaunchDescription([
        ExecuteProcess(cmd=command, name="{name}", cwd="{folder}", output="screen"),
        ExecuteProcess(cmd=["sleep", "1000"], name="other"),
    ])
"""


@pytest.mark.alone  # what `doctor --fix` of another test frees, the launcher cannot
@pytest.mark.thorough
def test_the_launcher_frees_what_no_other_node_has_read(launched_system: Launch, tmp_path: Path):
    file = tmp_path / "one.launch.py"
    file.write_text(ONE_NODE.format(name="monitor", folder=REPOSITORY))
    system = launched_system(file, probe=False, **LONG_STOP)
    # The launcher looks once a second what its processes hold.
    system.wait_for_log("monitor", "Fleet report", count=2)
    segments = segments_of(system, "monitor")
    assert segments
    system.kill("monitor")
    system.wait_for_log("launch", "of shared memory of killed nodes")
    assert not [path for path in segments if path.exists()]


def segments_of(system: LaunchedSystem, name: str) -> list[Path]:
    """What its process holds in /dev/shm, without ports."""
    pids = {row["pid"] for row in system.processes().values() if row["label"] == name}
    return [Path(FOLDER) / one for one, pid in held().items() if pid in pids and "_port" not in one]
