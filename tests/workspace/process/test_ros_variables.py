"""ROS_DISTRO, ROS_VERSION and ROS_PYTHON_VERSION are set as by a sourced ROS 2."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from launcher.packages.distribution import or_default

TIMEOUT_S = 60.0
DISTRO = or_default()
FILES = {
    "python.launch.py": """\
import os

from launch import LaunchDescription
from launch.actions import ExecuteProcess


def generate_launch_description():
    words = ["echo", "given", os.environ["ROS_DISTRO"]]
    return LaunchDescription(
        [ExecuteProcess(cmd=each, output="screen") for each in (words, ["env"])]
    )
""",
    "markup.launch.xml": """\
<launch>
  <executable cmd="echo given $(env ROS_DISTRO)" output="screen"/>
  <executable cmd="env" output="screen"/>
</launch>
""",
}


def launcher(folder: Path, *words: str, **variables: str) -> str:
    """The output; the variables are unset unless they are given."""
    env = {name: value for name, value in os.environ.items() if not name.startswith("ROS_")}
    env |= {"ROS_LOG_DIR": str(folder / "log"), **variables}
    command = [sys.executable, "-m", "launcher", *words]
    done = subprocess.run(
        command, cwd=folder, env=env, capture_output=True, text=True, timeout=TIMEOUT_S
    )
    assert done.returncode == 0, done
    return done.stdout


@pytest.mark.parametrize("name", FILES)
def test_launch_files_and_processes_see_them(name: str, tmp_path: Path):
    (tmp_path / name).write_text(FILES[name])

    default = launcher(tmp_path, name)
    own = launcher(tmp_path, name, ROS_DISTRO="rolling")

    for text in (
        f"given {DISTRO}",
        f"ROS_DISTRO={DISTRO}",
        "ROS_VERSION=2",
        "ROS_PYTHON_VERSION=3",
    ):
        assert text in default
    for text in ("given rolling", "ROS_DISTRO=rolling", "ROS_VERSION=2"):
        assert text in own


def test_programs_and_shells_see_them(tmp_path: Path):
    script = tmp_path / "share" / "ament_index" / "resource_index" / "packages" / "p"
    script.parent.mkdir(parents=True)
    script.touch()
    program = tmp_path / "lib" / "p" / "say"
    program.parent.mkdir(parents=True)
    program.write_text("#!/bin/sh\nenv\n")
    program.chmod(0o755)

    said = launcher(tmp_path, "run", "p", "say", AMENT_PREFIX_PATH=str(tmp_path)).splitlines()
    assert {f"ROS_DISTRO={DISTRO}", "ROS_VERSION=2", "ROS_PYTHON_VERSION=3"} <= {*said}
    assert {
        f"export ROS_DISTRO={DISTRO}",
        "export ROS_VERSION=2",
        "export ROS_PYTHON_VERSION=3",
    } <= {*launcher(tmp_path, "env").splitlines()}
