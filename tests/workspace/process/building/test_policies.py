"""The CMake files of the launcher do not depend on the policies of the packages that get them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.workspace.process.building.small_packages import built, cmake_package, message_package

MINIMUM = "cmake_minimum_required(VERSION {})\nproject(p)\n"
WRITTEN = "cmake_minimum_required(VERSION 3.10)\nproject(p C CXX)\n"
PROJECT_FIRST = "project(p)\ncmake_minimum_required(VERSION 3.5)\n"


def rewrite(folder: Path, head: str) -> None:
    """Begin the CMakeLists.txt of the package `p` in another way."""
    file = folder / "CMakeLists.txt"
    text = file.read_text(encoding="utf-8")
    assert text.startswith(WRITTEN)
    file.write_text(text.replace(WRITTEN, head), encoding="utf-8")


@pytest.mark.thorough
def test_a_project_before_the_minimum_version(tmp_path: Path):
    lines = "find_package(rosidl_default_generators REQUIRED)"
    folder = cmake_package(tmp_path / "src", "p", lines, languages="C CXX")
    rewrite(folder, PROJECT_FIRST)

    built(tmp_path)


@pytest.mark.thorough
@pytest.mark.parametrize("head", [PROJECT_FIRST, MINIMUM.format("3.3"), MINIMUM.format("3.28")])
def test_interfaces_under_any_policies(tmp_path: Path, head: str):
    rewrite(message_package(tmp_path / "src", "p"), head)

    built(tmp_path)
