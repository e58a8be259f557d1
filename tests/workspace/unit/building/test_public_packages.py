"""Packages that are built like well-known ones pass the checks before a build."""

from __future__ import annotations

from pathlib import Path

from launcher.workspace.building import checks, sources
from tests.support.public_packages import PACKAGES


def test_public_packages_have_no_mistakes(tmp_path: Path):
    for package in PACKAGES:
        package.write(tmp_path / "src")
    found = sources.find([str(tmp_path)], {})
    problems = checks.check(found, {}, install=str(tmp_path / "install"))
    assert len(found.packages) == len(PACKAGES)
    # Named in package.xml, but not looked for by CMake.
    assert sorted(str(problem.message) for problem in problems) == [
        "package 'osrf_pycommon' is neither in the workspace nor in the environment",
        "rclcpp has no wheel: C++ nodes need an installation of ROS 2",
    ]
    assert checks.warnings(problems) == problems
