"""The variables that name the installed ROS, as sourcing its set-up file sets them."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from launcher.packages.workspace import ROS_VARIABLES, ros_variables, source_installation

ROS = {"ROS_VERSION": "2", "ROS_PYTHON_VERSION": "3"}


def installation(prefix: Path, version: str) -> str:
    folder = prefix / "share" / "rclpy"
    folder.mkdir(parents=True)
    text = (
        f'<?xml version="1.0"?>\n<package format="2">\n  <version>{version}</version>\n</package>'
    )
    (folder / "package.xml").write_text(text)
    return str(prefix)


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
