"""The commands that get the sources of interface packages, with git and local repositories."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from launcher.packages.distribution import or_default
from launcher.packages.package_origins import HOST, SOURCES, clone_commands

DISTRO = or_default()
IDENTITY = ["-c", "user.name=nobody", "-c", "user.email=nobody@example.org"]


@pytest.fixture
def env(tmp_path: Path) -> dict[str, str]:
    """git takes the repositories of HOST from a folder, and no settings of this user."""
    return {
        **os.environ,
        "HOME": str(tmp_path),
        "GIT_CONFIG_NOSYSTEM": "1",
        "GIT_CONFIG_COUNT": "2",
        "GIT_CONFIG_KEY_0": f"url.file://{tmp_path}/hosted/.insteadOf",
        "GIT_CONFIG_VALUE_0": f"{HOST}/",
        "GIT_CONFIG_KEY_1": "uploadpack.allowFilter",
        "GIT_CONFIG_VALUE_1": "true",
    }


def host(env: dict[str, str], name: str, branch: str, *files: str) -> None:
    folder = Path(env["HOME"], "hosted", name)
    for file in files:
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text(file)
    for words in (["init", "-qb", branch], ["add", "."], [*IDENTITY, "commit", "-qm", "first"]):
        subprocess.run(["git", *words], cwd=folder, env=env, check=True)


def checked_out(env: dict[str, str], *packages: str) -> list[str]:
    workspace = Path(env["HOME"], "a workspace")
    workspace.mkdir()
    command = " && ".join(clone_commands(*packages))
    subprocess.run(["sh", "-c", command], cwd=workspace, env=env, check=True, timeout=60)
    files = [path.relative_to(workspace) for path in workspace.rglob("*") if path.is_file()]
    return sorted(str(file) for file in files if ".git" not in file.parts)


def test_a_repository_that_is_one_package_is_cloned_as_a_whole(env):
    host(env, "ros2/example_interfaces", DISTRO, "package.xml", "msg/Bool.msg")
    assert checked_out(env, "example_interfaces") == [
        "src/example_interfaces/msg/Bool.msg",
        "src/example_interfaces/package.xml",
    ]


def test_of_a_repository_with_other_packages_only_the_wanted_folders_are_there(env):
    files = [f"{name}/package.xml" for name in ("composition_interfaces", "statistics_msgs", "x")]
    host(env, "ros2/rcl_interfaces", DISTRO, *files)
    host(env, "ros2/geometry2", DISTRO, "tf2_ros/package.xml", "tf2_msgs/package.xml")
    wanted = ("composition_interfaces", "tf2_msgs", "statistics_msgs", "my_msgs")
    assert checked_out(env, *wanted) == [
        "src/geometry2/tf2_msgs/package.xml",
        "src/rcl_interfaces/composition_interfaces/package.xml",
        "src/rcl_interfaces/statistics_msgs/package.xml",
    ]


def test_unknown_packages_have_no_commands():
    assert clone_commands("my_msgs") == []
    assert all(clone_commands(name) for name in sorted(SOURCES))
