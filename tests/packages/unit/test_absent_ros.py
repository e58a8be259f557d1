"""What this Python lacks of ROS 2, and how to get it."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from launcher.base.errors import ExitCode, UsageError
from launcher.cli.absent_modules import absent_module
from launcher.language.diagnostics import import_hints
from launcher.packages import absent_ros
from launcher.packages.unknown import package_not_found
from launcher.workspace.building.checks import origins

OWN = f"{sys.version_info.major}.{sys.version_info.minor}"
# What the modules of verbs import of ROS 2.
OF_ROS = (
    *("rclpy", "rosidl_parser", "rcl_interfaces", "rosidl_adapter", "rosidl_generator_py"),
    *("action_msgs", "builtin_interfaces", "rosgraph_msgs", "lifecycle_msgs", "std_srvs"),
    *("diagnostic_msgs", "unique_identifier_msgs"),
)


@pytest.fixture
def bare(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """A Python without rclpy, in a shell where no ROS 2 was sourced."""
    for name in ("AMENT_PREFIX_PATH", "ROS_DISTRO", "ROS_VERSION", "ROS_PYTHON_VERSION"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "env"))
    found = absent_ros.is_installed
    monkeypatch.setattr(absent_ros, "is_installed", lambda name: name not in OF_ROS and found(name))
    return monkeypatch


def installation(prefix: Path, version: str, python: str) -> str:
    (prefix / "share/rclpy").mkdir(parents=True)
    (prefix / "share/rclpy/package.xml").write_text(f"<version>{version}</version>")
    (prefix / f"lib/python{python}/site-packages/rclpy").mkdir(parents=True)
    return str(prefix)


def error_of(name: str) -> str:
    found = absent_module(ModuleNotFoundError(f"No module named '{name}'", name=name))
    assert found is not None
    assert found.exit_code == ExitCode.USAGE
    return found.render()


@pytest.mark.parametrize("module", OF_ROS)
@pytest.mark.parametrize("named", [None, "humble", "lyrical", "rolling", "iron", "foo", "jazzy"])
def test_every_module_of_ros_that_is_absent_is_explained(
    bare: pytest.MonkeyPatch, named: str | None, module: str
):
    if named is not None:
        bare.setenv("ROS_DISTRO", named)
    said = error_of(module)

    assert f"this needs the Python package 'rclpy', which {sys.executable} does not have" in said
    assert "source the setup file of ROS 2" in said
    assert "launcher[jazzy]" in said
    assert ("unset ROS_DISTRO" in said) == (named not in (None, "jazzy"))


@pytest.mark.parametrize("module", ["rclpy._rclpy_pybind11", "rcl_interfaces", "numpy", "lark"])
def test_an_installation_for_another_python_is_named(
    bare: pytest.MonkeyPatch, module: str, tmp_path: Path
):
    bare.setenv("ROS_DISTRO", "humble")
    prefix = installation(tmp_path / "opt/ros/humble", "3.3.15", "3.2")
    bare.setenv("AMENT_PREFIX_PATH", prefix)
    said = error_of(module)

    assert f"ROS 2 Humble, from {prefix}, is for Python 3.2, not {OWN}: install" in said
    assert "where no ROS 2 was sourced" in said
    assert "launcher[jazzy]" in said


def test_an_installation_for_this_python_fits(bare: pytest.MonkeyPatch, tmp_path: Path):
    bare.setenv("AMENT_PREFIX_PATH", installation(tmp_path / "ros", "7.1.6", OWN))

    assert absent_ros.misfit() is None


def test_no_wheels_are_named_for_a_processor_without_them(bare: pytest.MonkeyPatch):
    machine = os.uname_result(("Linux", "bot", "6", "1", "aarch64"))
    bare.setattr(os, "uname", lambda: machine)

    assert absent_ros.ros_hint().endswith("ROS 2: there are no wheels for aarch64")


def test_one_hint_names_all_that_is_absent(bare: pytest.MonkeyPatch):
    known = absent_ros.is_installed
    bare.setattr(absent_ros, "is_installed", lambda name: name != "mcap" and known(name))
    with pytest.raises(UsageError) as caught:
        absent_ros.require("bag record", {"bag": "mcap"})

    assert "bag record needs the Python packages 'rclpy' and 'mcap'" in str(caught.value)
    assert "source the setup file of ROS 2 and run " in str(caught.value.hint)
    assert "launcher[bag]" in str(caught.value.hint)
    assert "launcher[jazzy,bag]" in str(caught.value.hint)


def test_what_is_there_is_not_asked_for():
    absent_ros.require("bag record", {"bag": "mcap"})


@pytest.mark.parametrize("package", ["std_msgs", "nav2_msgs"])
def test_a_package_of_ros_is_not_the_only_thing_that_is_absent(
    bare: pytest.MonkeyPatch, package: str
):
    error = ModuleNotFoundError(f"No module named '{package}'", name=package)
    hints = (
        package_not_found(package, [], []).hint,
        origins.missing(package, [])[1],
        import_hints.hint(error, str(error)),
    )
    for hint in hints:
        assert str(hint).startswith("there is no ROS 2: source the setup file of ROS 2, or install")
        assert "launcher[jazzy]" in str(hint)
