"""Mistakes that ROS 2 runs, as a run tells them: warnings, exit codes, and runs of nothing."""

from __future__ import annotations

from tests.support.benches import Workspace

WARNED = """
import os
from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument, ExecuteProcess, IncludeLaunchDescription, LogInfo)
from launch.substitutions import LaunchConfiguration

def generate_launch_description():
    d = LaunchConfiguration("d")
    return LaunchDescription([
        DeclareLaunchArgument("d", default_value="/tmp"),
        LogInfo(msg=f"in {d}"),
        LogInfo(msg="equal" if d == "/tmp" else "never equal"),
        IncludeLaunchDescription(
            os.path.join(os.path.dirname(__file__), "child.launch.xml"),
            launch_arguments=[("cuont", "2")]),
        ExecuteProcess(cmd=["echo started"]),
    ])
"""
NOTHING = """
launch:
- arg:
    name: robot
    default: "false"
- executable:
    cmd: touch started
    if: $(var robot)
"""
CHILD = '<launch><arg name="count" default="1"/><log message="count $(var count)"/></launch>'


def test_what_ros_2_runs_is_run_with_warnings(workspace: Workspace):
    (workspace.folder / "child.launch.xml").write_text(CHILD)
    file = workspace.folder / "warned.launch.py"
    file.write_text(WARNED)

    done = workspace.call(file)

    said = [line for line in done.stdout.splitlines() if line.startswith("[WARNING] [launch]: ")]
    expected = {
        11: "a LaunchConfiguration is used as text",
        12: "a LaunchConfiguration is compared with a text",
        15: "child.launch.xml does not declare the argument 'cuont'",
        16: "'echo started' is one word",
    }
    assert len(said) == len(expected), done.stdout
    for text, (line, message) in zip(said, expected.items(), strict=True):
        assert text.startswith(f"[WARNING] [launch]: {file}:{line + 1}: {message}")
    assert "[INFO] [launch.user]: never equal" in done.stdout
    assert "[INFO] [launch.user]: count 1" in done.stdout
    assert done.returncode == 1  # the process could not be started


def test_a_run_of_nothing_ends_with_0_and_names_the_false_condition(workspace: Workspace):
    file = workspace.folder / "nothing.launch.yaml"
    file.write_text(NOTHING)
    condition = (
        "started, since this condition is false: IfCondition(LaunchConfig('robot')) "
        "of ExecuteProcess at nothing.launch.yaml:6 (robot is 'false')\n"
    )

    run, plan, dry = (workspace.call(*words) for words in ([file], ["plan", file], ["-p", file]))

    assert f"[WARNING] [launch]: no process was {condition}" in run.stdout
    for one in (plan, dry):
        assert f"warning: no process would be {condition}" in one.stdout
    assert [one.returncode for one in (run, plan, dry)] == [0, 0, 0]
    assert not (workspace.folder / "started").exists()


def test_a_warning_about_the_reason_precedes_the_error_that_ends_a_launch(workspace: Workspace):
    file = workspace.folder / "named.launch.py"
    file.write_text(
        "from launch import LaunchDescription\n"
        "from launch.substitutions import LaunchConfiguration\n"
        "from launch_ros.actions import Node\n"
        "def generate_launch_description():\n"
        "    name = f\"{LaunchConfiguration('name')}_node\"\n"
        "    return LaunchDescription([Node(package='p', executable='e', name=name)])\n"
    )

    done = workspace.call(file)

    warning, error, *_ = done.stderr.splitlines()
    assert warning.startswith(f"warning: {file}:5: a LaunchConfiguration is used as text")
    assert "write [LaunchConfiguration('name'), '_node']" in warning
    assert error.startswith(f"error: {file}:6: Invalid node name")
    assert done.returncode == 2


PROGRAMS = """
from launch import LaunchDescription
from launch.actions import ExecuteProcess, TimerAction
from launch_ros.actions import Node

def generate_launch_description():
    return LaunchDescription([
        Node(executable="./no_bit.py"),
        ExecuteProcess(cmd=["windows.sh"], cwd="scripts"),
        Node(executable="node_of_a_package"),
        ExecuteProcess(cmd=["echo", "runs"], output="screen"),
        TimerAction(period=0.1, actions=[ExecuteProcess(cmd=["./late.sh"])]),
    ])
"""
NO_BIT = (
    "'./no_bit.py' is not executable; hint: chmod +x ./no_bit.py, and write "
    "'#!/usr/bin/env python3' into its first line"
)
NOT_IN_PATH = (
    "there is no program 'windows.sh' in PATH; hint: write './windows.sh' for the file in the "
    "working directory"
)
NO_PACKAGE = "there is no program 'node_of_a_package' in PATH; hint: give its package=, or a path"
LATE = "the '#!' line of './late.sh' names '/no/such', which does not exist"


def test_programs_that_cannot_be_executed_are_reported_before_the_start(workspace: Workspace):
    folder = workspace.folder
    (folder / "scripts").mkdir()
    (folder / "scripts" / "windows.sh").write_bytes(b"#!/bin/sh\r\n")
    (folder / "no_bit.py").write_text("print(1)\n")
    (folder / "late.sh").write_text("#!/no/such\n")
    (folder / "late.sh").chmod(0o755)
    file = folder / "programs.launch.py"
    file.write_text(PROGRAMS)
    texts = (NO_BIT, NOT_IN_PATH, NO_PACKAGE)

    done = workspace.call(file)

    lines = done.stdout.splitlines()
    warned = [line for line in lines if line.startswith("[WARNING] [launch]: ")]
    expected = [f"{file}:{line}: {text}" for line, text in enumerate(texts, 8)]
    assert [line.partition("]: ")[2] for line in warned] == expected, done.stdout
    first = next(number for number, line in enumerate(lines) if "process" in line)
    assert all(lines.index(line) < first for line in warned)
    assert "[echo-4] runs" in lines
    (late,) = [line for line in lines if "[late.sh-5]: process could not be started" in line]
    assert late.endswith(f"No such file or directory, cmd './late.sh'; {LATE}")
    assert done.returncode == 1

    plan = workspace.call("plan", file).stdout.splitlines()

    warned = [line for line in plan if line.startswith("warning: ")]
    assert warned == [f"warning: {one}" for one in (*expected, f"{file}:12: {LATE}")]
