"""Which ROS 2 is in use, and the variables that name it, as sourcing its set-up file sets them."""

from __future__ import annotations

import os
import sys
from importlib import metadata
from pathlib import Path

import pytest

from launcher.packages import distribution
from launcher.packages.distribution import ROS_VARIABLES, ros_variables, source_installation

ROS = {"ROS_VERSION": "2", "ROS_PYTHON_VERSION": "3"}


def installation(prefix: Path, version: str) -> str:
    folder = prefix / "share" / "rclpy"
    folder.mkdir(parents=True)
    text = (
        f'<?xml version="1.0"?>\n<package format="2">\n  <version>{version}</version>\n</package>'
    )
    (folder / "package.xml").write_text(text)
    return str(prefix)


def wheels(prefix: Path, *names: str) -> None:
    python = f"python{sys.version_info.major}.{sys.version_info.minor}"
    for name in ("ros_rclpy-1.0.0.dist-info", *names):
        (prefix / "lib" / python / "site-packages" / name).mkdir(parents=True)


@pytest.mark.parametrize(
    ("version", "named"),
    [
        ("7.1.6", {"ROS_DISTRO": "jazzy"}),
        ("3.3.15", {"ROS_DISTRO": "humble"}),
        ("10.0.2", {"ROS_DISTRO": "lyrical"}),
        ("99.0.0", {}),
        ("", {}),
    ],
)
def test_the_version_of_rclpy_tells_the_distribution(
    version: str, named: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(sys, "prefix", installation(tmp_path, version))

    assert ros_variables({}) == {**named, **ROS}


def test_a_prefix_that_is_named_comes_before_the_wheels(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(sys, "prefix", installation(tmp_path / "wheels", "7.1.6"))
    ros = installation(tmp_path / "ros", "9.1.2")

    assert ros_variables({"AMENT_PREFIX_PATH": f"/nothing:{ros}"})["ROS_DISTRO"] == "kilted"


def test_without_ros_there_are_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "prefix", str(tmp_path))

    assert ros_variables({}) == {}


def test_what_the_user_has_set_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "prefix", installation(tmp_path, "7.1.6"))
    for name in ROS_VARIABLES:
        monkeypatch.setenv(name, "mine")  # so that it is restored
        monkeypatch.delenv(name)
    monkeypatch.setenv("ROS_DISTRO", "rolling")

    source_installation()

    assert {name: os.environ[name] for name in ROS_VARIABLES} == {"ROS_DISTRO": "rolling", **ROS}


@pytest.mark.parametrize(
    ("hook", "text"),
    [
        ("1.ros_distro.dsv", "set;ROS_DISTRO;rolling\n"),
        ("1.ros_distro.sh", "# generated\nexport ROS_DISTRO=rolling\n"),
    ],
)
def test_what_the_prefix_sets_comes_before_the_version(hook: str, text: str, tmp_path: Path):
    ros = installation(tmp_path / "pixi", "10.0.2")
    folder = Path(ros, "share/ros_environment/environment")
    folder.mkdir(parents=True)
    (folder / hook).write_text(text)

    assert distribution.installed({"AMENT_PREFIX_PATH": ros}) == "rolling"


def test_a_folder_of_opt_ros_names_the_distribution(tmp_path: Path):
    ros = installation(tmp_path / "opt/ros/moonshot", "42.0.0")

    assert distribution.installed({"AMENT_PREFIX_PATH": ros}) == "moonshot"
    assert distribution.title({"AMENT_PREFIX_PATH": ros}) == f"ROS 2 Moonshot, from {ros}"


def test_wheels_of_a_new_distribution_name_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "prefix", installation(tmp_path, "42.0.0"))
    assert distribution.title({}) == f"ROS 2 with rclpy 42.0.0, from {tmp_path}"
    assert distribution.installed({"ROS_DISTRO": "rolling"}) == "rolling"
    wheels(tmp_path, "ros_moonshot_rclpy-42.0.0.dist-info")

    assert distribution.title({}) == "ROS 2 Moonshot, from wheels"


def test_where_there_is_no_ros_the_variable_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "prefix", str(tmp_path))

    assert distribution.installed({}) is None
    assert distribution.installed({"ROS_DISTRO": "kilted"}) == "kilted"
    assert distribution.or_default({}) == "jazzy"
    assert distribution.title({}) == "no ROS 2"
    assert distribution.conflict({}) is None


def test_a_variable_that_names_another_distribution_is_a_conflict(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(sys, "prefix", installation(tmp_path, "9.1.2"))

    assert distribution.installed({"ROS_DISTRO": "jazzy"}) == "kilted"
    assert distribution.conflict({"ROS_DISTRO": "jazzy"}) == (
        f"ROS_DISTRO is jazzy, but the rclpy in {tmp_path} is of kilted"
    )


def test_python_that_imports_another_rclpy_is_a_conflict(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    ros = installation(tmp_path / "opt/ros/kilted", "9.1.2")
    there = Path(ros, "lib/python3/site-packages")
    for place in (there, tmp_path / "elsewhere"):
        (place / "rclpy").mkdir(parents=True)
        (place / "rclpy/__init__.py").touch()
    monkeypatch.delitem(sys.modules, "rclpy", raising=False)
    monkeypatch.setattr(sys, "path", [str(there)])
    assert distribution.conflict({"AMENT_PREFIX_PATH": ros}) is None
    monkeypatch.setattr(sys, "path", [str(tmp_path / "elsewhere")])

    assert distribution.conflict({"AMENT_PREFIX_PATH": ros}) == (
        f"packages are those of {ros}, but Python imports rclpy from {tmp_path}/elsewhere/rclpy"
    )


@pytest.mark.parametrize(
    ("version", "variable"),
    [
        ("3.3.15", "FASTRTPS_DEFAULT_PROFILES_FILE"),
        ("7.1.6", "FASTRTPS_DEFAULT_PROFILES_FILE"),
        ("9.1.2", "FASTDDS_DEFAULT_PROFILES_FILE"),
        ("10.0.2", "FASTDDS_DEFAULT_PROFILES_FILE"),
    ],
)
def test_the_variable_for_profiles_is_that_of_the_fast_dds(
    version: str, variable: str, tmp_path: Path
):
    ros = installation(tmp_path, version)

    assert distribution.profiles_variable({"AMENT_PREFIX_PATH": ros}) == variable


@pytest.mark.parametrize("name", distribution.EXTRAS)
def test_a_distribution_with_wheels_is_an_extra(name: str):
    wanted = metadata.requires("ros2-launcher") or []
    assert any(one.startswith(f"ros-{name}-rclpy[fastrtps]") for one in wanted)
    assert distribution.with_wheels({"AMENT_PREFIX_PATH": "", "ROS_DISTRO": "x"}) in (
        distribution.EXTRAS
    )
