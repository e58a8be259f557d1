"""The ways to install: colcon (plain and symlinked), and both distributions by pip."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
import venv
from importlib import metadata
from pathlib import Path

import pytest

from launcher import __version__
from launcher.packages import finder
from launcher.packages.distribution import with_wheels
from tests.support.repository import REPOSITORY, pins
from tests.system.conftest import LONG_STOP_WORDS, World

BUILD_S = 500.0
TEXTS = {".py", ".toml", ".js", ".html", ".in", ".cmake", ".json", ".xml"}
PROGRAMS = {path.stem for path in (REPOSITORY / "group_gp1").glob("*.py")}  # each of the fleet's


def run(*command: str, cwd: Path, env: dict[str, str] | None = None) -> str:
    done = subprocess.run(
        command, cwd=cwd, env=env, capture_output=True, text=True, timeout=BUILD_S, check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    """The tracked files, without what a build or an editable install has left in the checkout."""
    target = tmp_path / "workspace" / "src" / "group_gp1"
    listed = run("git", "ls-files", "--cached", "--others", "--exclude-standard", cwd=REPOSITORY)
    for name in listed.splitlines():
        source = REPOSITORY / name
        if source.is_file():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source, target / name)
    return target


def test_only_the_launcher_is_on_path():
    names = {
        name: {(point.group, point.name) for point in metadata.distribution(name).entry_points}
        for name in ("ros2-launcher", "group_gp1")
    }
    assert names["ros2-launcher"] == {
        ("console_scripts", "launch_test"),  # which leaves the test to an installed launch_testing
        ("pytest11", "launcher"),
        ("pytest11", "launcher_launch_tests"),
    }
    # No console script, but a script beside that of `launch_test`, in which it looks for Python.
    files = metadata.distribution("ros2-launcher").files or ()
    assert {path.name for path in files if path.parent.name == "bin"} >= {"launcher", "launch_test"}
    assert {group for group, _ in names["group_gp1"]} == {"launcher.programs"}
    assert "all" in metadata.metadata("ros2-launcher").get_all("Provides-Extra", ())
    assert metadata.requires("group_gp1") == ["ros2-launcher"]


def test_programs_that_are_not_on_path_are_found():
    nodes = {"debug_logger", "dispatcher", "monitor", "qos_probe"}
    nodes |= {"robot", "robot_1", "robot_2", "robot_3"}
    assert set(finder.executables("group_gp1", os.environ)) == nodes


def test_the_launcher_names_no_package_of_the_fleet():
    texts = (path for path in (REPOSITORY / "launcher").rglob("*") if path.suffix in TEXTS)
    assert [str(path) for path in texts if "group_gp1" in path.read_text(encoding="utf-8")] == []


@pytest.mark.thorough
@pytest.mark.parametrize("options", [(), ("--symlink-install",)], ids=["plain", "symlink"])
def test_colcon_builds_the_workspace_and_its_nodes_run(sources: Path, world: World, options):
    workspace = sources.parent.parent
    colcon = Path(sys.executable).with_name("colcon")
    tools = {**os.environ, "PATH": f"{colcon.parent}:{os.environ['PATH']}"}
    run(str(colcon), "build", *options, cwd=workspace, env=tools)

    program = workspace / "install/group_gp1/lib/group_gp1/dispatcher"
    setup = workspace / "install/setup.sh"
    node = world.terminal("sh", "-c", f". {setup} && exec {program}", cwd=workspace)
    node.wait_for("Assigned task pick_shelf_A3 to robot_1")
    node.ctrl_c()
    assert node.exit_code() == 0

    # The workspace's launch file is found by package and file, as `ros2 launch` finds it.
    words = shlex.join(world.command("group_gp1", "system.launch.py", *LONG_STOP_WORDS))
    started = world.terminal("sh", "-c", f". {setup} && exec {words}", cwd=workspace)
    started.wait_for("[dispatcher]: Assigned task pick_shelf_A3 to robot_1")
    started.ctrl_c()
    assert started.exit_code() == 0
    share = workspace / "install/group_gp1/share/group_gp1/launch"
    installed = {path.name for path in share.iterdir()}
    files = [path for path in (REPOSITORY / "launch").iterdir() if path.is_file()]
    assert installed == {path.name for path in files if not path.name.startswith(".")}


@pytest.mark.thorough
def test_pip_installs_a_launcher_that_works_outside_of_the_source_tree(
    sources: Path, world: World, tmp_path: Path
):
    home = tmp_path / "venv"
    venv.create(home, with_pip=True)
    python = str(home / "bin" / "python")
    wheels = tmp_path / "wheels"
    wheel = (python, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(wheels))
    run(*wheel, "./launcher", ".", cwd=sources)
    install = (python, "-m", "pip", "install", "--quiet", "-c", str(pins()))
    found = {path.name.partition("-")[0]: path for path in wheels.iterdir()}
    ours = f"{found['ros2_launcher']}[{with_wheels()}]"
    run(*install, ours, str(found["group_gp1"]), cwd=sources)

    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    launcher = str(home / "bin" / "launcher")
    said = f"{__version__} (ROS 2 {with_wheels().title()}, from wheels)\n"
    assert run(launcher, "--version", cwd=elsewhere) == said
    assert {path.name for path in (home / "bin").iterdir()}.isdisjoint(PROGRAMS)
    module = "import launch; print(launch.LaunchService.__module__)"
    assert run(python, "-c", module, cwd=elsewhere) == "launch.launch_service\n"
    fleet = world.terminal(python, "-m", "launcher", "system", *LONG_STOP_WORDS, cwd=elsewhere)
    fleet.wait_for("[dispatcher]: Assigned task pick_shelf_A3 to robot_1")
    fleet.wait_for("[robot_1]: Received task ")
    fleet.ctrl_c()
    assert fleet.exit_code() == 0

    # what is read besides code
    share = home / "share" / "group_gp1" / "launch"
    assert (share / "system.expect.yaml").is_file()
    for file in (
        "ros/probe/participant.xml",
        "ros/topics/publisher.xml",
        "ros/draw/page.html",
        "py.typed",
    ):
        assert list(home.rglob(f"launcher/{file}")), file

    node = world.terminal(launcher, "run", "group_gp1", "dispatcher", cwd=elsewhere)
    node.wait_for("Assigned task pick_shelf_A3 to robot_1")
    node.ctrl_c()
    assert node.exit_code() == 0
