"""What the checks do not refuse any more, built by the real tools."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.workspace.process.building.small_packages import (
    build,
    built,
    cmake_package,
    message_package,
    write,
)


@pytest.mark.thorough
def test_interfaces_in_subfolders_and_from_elsewhere(tmp_path: Path):
    """The files of `low` are in its own subfolders, those of `high` are exported by `low`."""
    src = tmp_path / "src"
    folder = message_package(src, "low", "msg/deep/Leaf.msg", "srv/Other.srv", "srv/deep/Take.srv")
    for name in ("Other", "deep/Take"):
        write(folder / "srv" / f"{name}.srv", "Leaf now\n---\n")
    export = 'ament_package(CONFIG_EXTRAS_POST "files.cmake")\ninstall(DIRECTORY msg DESTINATION .)'
    text = (folder / "CMakeLists.txt").read_text(encoding="utf-8")
    write(folder / "CMakeLists.txt", text.replace("ament_package()", export))
    base = '"${low_DIR}/../../..:msg/deep/Leaf.msg"'
    write(folder / "files.cmake", f"set(low_files {base})\n")
    other = message_package(src, "high", "msg/Tree.msg", depends=["low"])
    write(other / "msg" / "Tree.msg", "high/Leaf leaf\nlow/Leaf[] leaves\n")
    text = (other / "CMakeLists.txt").read_text(encoding="utf-8")
    write(other / "CMakeLists.txt", text.replace('"msg/Tree.msg"', '"msg/Tree.msg" ${low_files}'))

    result = built(tmp_path)

    assert "'high/Leaf' is none of the types that are known before CMake runs" in result.err
    assert "2 built" in result.summary


@pytest.mark.thorough
def test_a_package_that_hides_one_that_other_wheels_use(tmp_path: Path):
    """service_msgs, which services need, is linked to builtin_interfaces, for C++ too."""
    times = ("msg/Time.msg", "msg/Duration.msg")
    folder = message_package(tmp_path / "src", "builtin_interfaces", *times)
    write(folder / "msg" / "Time.msg", "int32 sec\nuint32 nanosec\n")
    write(folder / "msg" / "Duration.msg", "int32 sec\nuint32 nanosec\n")
    folder = message_package(tmp_path / "src", "m", "srv/Go.srv", depends=["builtin_interfaces"])
    write(folder / "srv" / "Go.srv", "builtin_interfaces/Time at\n---\n")

    assert "2 built" in built(tmp_path).summary


@pytest.mark.thorough
def test_a_package_that_names_what_it_needs_by_another_one(tmp_path: Path):
    cmake_package(tmp_path / "src", "a")
    cmake_package(tmp_path / "src", "b", depends=["a"])
    folder = cmake_package(tmp_path / "src", "c", "find_package(a REQUIRED)", depends=["b"])
    manifest = (folder / "package.xml").read_text(encoding="utf-8")
    write(folder / "package.xml", manifest.replace("<export>", "<export><buildtype>x</buildtype>"))

    assert built(tmp_path).err == ""


def test_a_package_of_files_needs_no_compiler(tmp_path: Path):
    cmake_package(tmp_path / "src", "files", languages="NONE")
    env = {**os.environ, "PATH": "", "CC": "/nothing", "CXX": "/nothing"}

    result = build(tmp_path, env=env)

    assert (result.code, result.err) == (0, "")
