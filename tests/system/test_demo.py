"""`launcher demo` where pip has installed the launcher alone: no clone, no package of the fleet."""

from __future__ import annotations

import os
import re
import sys
import zipfile
from pathlib import Path

import pytest

from tests.support.environments import Environment, environment_with_ros
from tests.support.repository import REPOSITORY
from tests.system.conftest import LONG_STOP_WORDS, World
from tests.system.test_packaging import sources

__all__ = ["sources"]
pytestmark = pytest.mark.thorough
SDIST = "import setuptools.build_meta as b, sys; print(b.build_sdist(sys.argv[1]))"


@pytest.fixture
def environment(tmp_path: Path) -> Environment:
    return environment_with_ros(tmp_path / "venv")


def wheel_of(source: Path, environment: Environment, folder: Path) -> Path:
    options = ("--quiet", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder))
    environment.pip("wheel", *options, str(source))
    (wheel,) = folder.glob("*.whl")
    return wheel


def test_the_fleet_runs_from_the_wheel(
    sources: Path, environment: Environment, world: World, tmp_path: Path
):
    wheel = wheel_of(sources / "launcher", environment, tmp_path / "wheels")
    environment.pip("install", "--quiet", "--no-deps", str(wheel))
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    launcher = (str(environment.prefix / "bin/launcher"),)
    set_there = {name: text for name, text in world.env.items() if os.environ.get(name) != text}
    env = {**environment.variables, **set_there}

    words = ("demo", "start_robot_2:=false", *LONG_STOP_WORDS)
    fleet = world.terminal(*launcher, *words, cwd=elsewhere, env=env)
    fleet.wait_for("[robot_1]: Received task ")
    fleet.wait_for("Fleet report -- robot_1: ")
    # The package is found by its name, from another shell, too; no list has it.
    late = world.terminal(*launcher, "run", "group_gp1", "robot_2", cwd=elsewhere, env=env)
    late.wait_for("Received task ")
    late.ctrl_c()
    assert late.exit_code() == 0
    assert "group_gp1" not in environment.run("-m", "launcher", "pkg", "list", cwd=elsewhere)
    fleet.ctrl_c()
    assert fleet.exit_code() == 0
    assert list(elsewhere.iterdir()) == []


def test_an_sdist_makes_the_same_wheel(sources: Path, environment: Environment, tmp_path: Path):
    direct = wheel_of(sources / "launcher", environment, tmp_path / "direct")
    name = environment.run("-c", SDIST, str(tmp_path), cwd=sources / "launcher").split()[-1]
    again = wheel_of(tmp_path / name, environment, tmp_path / "again")

    files = set(zipfile.ZipFile(direct).namelist())
    metadata = next(one for one in files if one.endswith(".dist-info/METADATA"))
    assert b"\n# ros2-launcher\n" in zipfile.ZipFile(direct).read(metadata)
    assert {f"launcher/demo_package/{part}" for part in fleet_files()} <= files
    assert set(zipfile.ZipFile(again).namelist()) == files


def fleet_files() -> set[str]:
    code = (REPOSITORY / "group_gp1").rglob("*.py")
    launch_files = (REPOSITORY / "launch").glob("*.launch.py")
    found = {str(path.relative_to(REPOSITORY)) for path in (*code, *launch_files)}
    return found | {"package.xml", "setup.py", "resource/group_gp1"}


def test_a_launcher_that_an_old_pip_has_built_elsewhere_has_no_demo(
    sources: Path, environment: Environment, tmp_path: Path
):
    moved = (sources / "launcher").rename(sources / "pip-req-build-x1")
    wheel = wheel_of(moved, environment, tmp_path / "wheels")

    assert not [name for name in zipfile.ZipFile(wheel).namelist() if "demo_package" in name]


def test_the_readme_of_the_wheel_has_a_launch_file_that_runs(world: World, tmp_path: Path):
    text = (REPOSITORY / "launcher/README.md").read_text(encoding="utf-8")
    (launch_file,) = re.findall(r"```xml\n(.*?)```", text, re.DOTALL)
    (tmp_path / "hello.launch.xml").write_text(launch_file)
    env = {**world.env, "PATH": f"{Path(sys.executable).parent}:{world.env['PATH']}"}

    run = world.terminal("launcher", "hello.launch.xml", cwd=tmp_path, env=env)
    run.wait_for("data: hello")
    run.ctrl_c()
    assert run.exit_code() == 0
