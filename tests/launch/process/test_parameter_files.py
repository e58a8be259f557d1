"""Warnings of parameter files that no node uses, in a run and in its plan."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

LAUNCH = """
from launch import LaunchDescription
from launch.actions import TimerAction
from launch_ros.actions import Node

def generate_launch_description():
    late = Node(executable="true", name="late", parameters=["late.yaml"])
    return LaunchDescription([
        Node(executable="true", name="talker", namespace="ns", parameters=["nav.yaml"]),
        Node(executable="true", name="camera", parameters=["late.yaml"]),
        TimerAction(period=0.2, actions=[late]),
    ])
"""
WARNING = (
    "a.launch.py:9: the parameter file nav.yaml has nothing for /ns/talker: it is for /talker; "
    "hint: write '/ns/talker:', or '/**/talker:' for any namespace"
)


def launcher(folder: Path, *words: str) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "launcher", *words],
        cwd=folder,
        env={**os.environ, "ROS_LOG_DIR": str(folder / "log")},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_a_file_whose_keys_match_no_node_is_reported_before_the_first_process(tmp_path: Path):
    (tmp_path / "a.launch.py").write_text(LAUNCH)
    for name, key in (("nav", "talker"), ("late", "late")):
        (tmp_path / f"{name}.yaml").write_text(f"{key}: {{ros__parameters: {{p: 1}}}}\n")
    lines = launcher(tmp_path, "a.launch.py").splitlines()
    reported = [number for number, line in enumerate(lines) if "the parameter file" in line]
    started = [number for number, line in enumerate(lines) if "process started" in line]
    assert len(reported) == 1
    assert lines[reported[0]].endswith(WARNING)
    assert reported[0] < started[0]
    plan = launcher(tmp_path, "plan", "a.launch.py").splitlines()
    assert [line for line in plan if "the parameter file" in line] == [plan[-1]]
    assert plan[-1].endswith(WARNING)
