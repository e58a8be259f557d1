"""Each well-known package has one origin, and the messages about missing packages name it."""

from __future__ import annotations

import re
from importlib import metadata

import pytest

from launcher.base.package_origins import (
    SOURCES,
    clone_commands,
    has_wheel,
    is_of_launcher,
    needs_ros,
)
from launcher.packages.unknown import package_not_found
from launcher.workspace.building.checks import origins

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
    found = [name for name in names if re.match("ros[-_]jazzy[-_]", name)]
    assert found
    assert all(has_wheel(re.split("[-_]", name, maxsplit=2)[2].replace("-", "_")) for name in found)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("ros_environment", "--branch jazzy https://github.com/ros/ros_environment"),
        ("autoware_map_msgs", "sparse-checkout add autoware_map_msgs"),
        ("test_msgs", "install its wheel: pip install ros-jazzy-test-msgs"),
        ("tf2_ros", "with an installation of ROS 2"),
    ],
)
def test_a_missing_package_is_told_with_its_origin(name: str, said: str):
    assert said in origins.missing(name, [])[1]
    assert said in str(package_not_found(name, [], []).hint)


def test_the_distribution_in_use_is_named(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("ROS_DISTRO", "humble")

    assert "(ros-humble-tf2-ros)" in origins.missing("tf2_ros", [])[1]
    assert "(apt install ros-humble-tf2-ros)" in str(package_not_found("tf2_ros", [], []).hint)


def test_a_package_that_the_launcher_replaces_needs_nothing():
    assert origins.missing("launch_ros", [])[1].startswith("leave it out")
