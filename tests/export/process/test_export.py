"""`export` as a command: the same bytes each time, and clear errors."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from launcher.export.verbs.export import ENGINES
from tests.support.repository import REPOSITORY
from tests.support.variations import few_of

LAUNCH_FILE = """
from launch import LaunchDescription
from launch.actions import OpaqueFunction, TimerAction
from launch_ros.actions import Node

def of_function(context):
    return [node("robot_3")]

def node(name, **more):
    return Node(package="group_gp1", executable="robot_1", name=name, **more)

def generate_launch_description():
    return LaunchDescription([
        node("robot_1", namespace="/warehouse", parameters=[{"a": 1, "b": [1.5, 2.5]}]),
        node("robot_1", namespace="/yard", additional_env={"SET_HERE": "1"}),
        TimerAction(period=5.0, actions=[node("robot_2", parameters=["own.yaml"])]),
        OpaqueFunction(function=of_function),
    ])
"""
SUBNET = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
HOSTS = """
hosts:
  bot1: {address: 10.0.0.2, user: robot, environment: {FLEET_TOKEN: hush}}
place:
  robot_2: bot1
"""


def export(folder: Path, *words: str, home: str = "/nowhere") -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "launcher", "export", *words],
        cwd=folder,
        env={**os.environ, **SUBNET, "HOME": home, "PYTHONPATH": str(REPOSITORY), "USER": home[1:]},
        capture_output=True,
        text=True,
        timeout=60,
    )


def folder_with_files(path: Path) -> Path:
    path.mkdir(parents=True)
    (path / "demo.launch.py").write_text(LAUNCH_FILE)
    (path / "own.yaml").write_text("/**: {ros__parameters: {x: 1}}\n")
    (path / "hosts.yaml").write_text(HOSTS)
    return path


def content(folder: Path) -> dict[str, bytes]:
    return {
        str(one.relative_to(folder)): one.read_bytes() for one in folder.rglob("*") if one.is_file()
    }


@pytest.mark.parametrize("engine", few_of(ENGINES, ["systemd", "kubernetes"]))
def test_the_same_input_gives_the_same_bytes_on_another_machine(tmp_path: Path, engine: str):
    """In other folders, for another user, with other hash seeds."""
    written = []
    for number in ("1", "22"):
        folder = folder_with_files(tmp_path / f"place-{number}" / "deep" / number)
        out = tmp_path / f"out-{number}"
        words = (engine, "demo.launch.py", "--hosts", "hosts.yaml", "--out", str(out))
        done = export(folder, *words, home=f"/home/{number}")
        assert done.returncode == 0, done.stderr
        written.append(content(out))
    assert written[0] == written[1]
    everything = b"".join(written[0].values())
    assert b"hush" not in everything
    assert str(tmp_path).encode() not in everything
    assert sys.prefix.encode() not in everything


def test_each_process_of_the_plan_has_a_file(tmp_path: Path):
    folder = folder_with_files(tmp_path / "a")
    assert export(folder, "kubernetes", "demo.launch.py").returncode == 0
    assert sorted(path.stem for path in (folder / "kubernetes" / "manifests").iterdir()) == [
        *("robot-2", "robot-3", "warehouse-robot-1", "yard-robot-1")
    ]


def test_what_is_not_exported_is_told_on_standard_error(tmp_path: Path):
    folder = folder_with_files(tmp_path / "a")
    done = export(folder, "systemd", "demo.launch.py")
    assert "note: demo.launch.py:17: OpaqueFunction of_function: " in done.stderr
    assert done.stdout == "4 processes exported to systemd, see README.md there\n"


def test_strict_writes_nothing_if_something_is_lost(tmp_path: Path):
    (tmp_path / "demo.launch.py").write_text(
        LAUNCH_FILE.replace("OpaqueFunction(function=of_function)", "node('a', on_exit=[])")
    )
    (tmp_path / "own.yaml").touch()
    done = export(tmp_path, "compose", "demo.launch.py", "--strict")
    assert done.returncode == 2
    assert "not exported: demo.launch.py:10: on_exit (a): " in done.stderr
    assert "1 thing of the launch file cannot be exported" in done.stderr
    assert not (tmp_path / "compose").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["sytemd", "demo.launch.py"], "did you mean 'systemd'?"),
        (["systemd", "dmo.launch.py"], "dmo.launch.py"),
        (["systemd"], "the launch file is missing"),
        (["systemd", "demo.launch.py", "speed:=1"], "speed"),
        (["systemd", "demo.launch.py", "--hosts", "none.yaml"], "none.yaml"),
        (
            ["systemd", "demo.launch.py", "--prefix", "a b"],
            "--prefix: 'a b' is not a valid prefix",
        ),
        (["systemd", "demo.launch.py", "--out", "."], "not of an export"),
        (["systemd", "demo.launch.py", "--out", "own.yaml"], "is not a folder"),
    ],
)
def test_errors(tmp_path: Path, words: list[str], message: str):
    folder = folder_with_files(tmp_path / "a")
    before = content(folder)
    done = export(folder, *words)
    assert done.returncode == 2, done.stderr
    assert message in done.stderr
    assert content(folder) == before


def test_a_launch_file_that_starts_nothing_is_an_error(tmp_path: Path):
    text = (
        "from launch import LaunchDescription as D\ngenerate_launch_description = lambda: D([])\n"
    )
    (tmp_path / "demo.launch.py").write_text(text)
    done = export(tmp_path, "systemd", "demo.launch.py")
    assert done.returncode == 2
    assert "starts no process" in done.stderr
