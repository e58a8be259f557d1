"""Packages of the workspace with the name of an installed one."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from launcher.workspace.building import checks, sources
from tests.workspace.unit.building.source_tree import manifest

TAGS = (
    "<buildtool_depend>ament_cmake</buildtool_depend>",
    "<buildtool_depend>rosidl_default_generators</buildtool_depend>",
    "<depend>builtin_interfaces</depend>",
    "<exec_depend>rosidl_default_runtime</exec_depend>",
    "<member_of_group>rosidl_interface_packages</member_of_group>",
)
CMAKE = """cmake_minimum_required(VERSION 3.8)
project({name})
find_package(ament_cmake REQUIRED)
find_package(builtin_interfaces REQUIRED)
find_package(rosidl_default_generators REQUIRED)
file(GLOB files RELATIVE ${{CMAKE_CURRENT_SOURCE_DIR}} msg/*.msg srv/*.srv)
rosidl_generate_interfaces(${{PROJECT_NAME}} ${{files}} DEPENDENCIES builtin_interfaces)
ament_export_dependencies(rosidl_default_runtime)
ament_package()
"""


def copied(tmp_path: Path, name: str) -> Path:
    """The sources of an installed interface package, as its repository has them."""
    folder = tmp_path / "src" / name
    for file in Path(sys.prefix, "share", name).glob("[ms][sr][gv]/*.[ms][sr][gv]"):
        target = folder / file.relative_to(Path(sys.prefix, "share", name))
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(file.read_text(encoding="utf-8"), encoding="utf-8")
    (folder / "package.xml").write_text(manifest(name, *TAGS))
    (folder / "CMakeLists.txt").write_text(CMAKE.format(name=name))
    return folder


def warnings(tmp_path: Path) -> list[str]:
    found = sources.find([str(tmp_path)], {})
    problems = checks.check(found, {}, install=str(tmp_path / "install"))
    assert checks.errors(problems) == []
    return [str(problem.message) for problem in problems]


def test_a_copy_of_an_installed_package_may_have_other_comments(tmp_path: Path):
    header = copied(tmp_path, "std_msgs") / "msg/Header.msg"
    header.write_text(f"# Another comment\n\n{header.read_text()}  # and one more\n")
    assert warnings(tmp_path) == []


@pytest.mark.parametrize("change", ["{0}float64 extra\n", "", None])
def test_installed_packages_do_not_fit_to_other_fields(tmp_path: Path, change: str | None):
    header = copied(tmp_path, "std_msgs") / "msg/Header.msg"
    if change is None:
        header.unlink()
    else:
        header.write_text(change.format(header.read_text() + "\n"))
    assert warnings(tmp_path) == [
        "std_msgs hides the installed package, which has other fields in msg/Header: "
        "actionlib_msgs, diagnostic_msgs, geometry_msgs and 5 more would read wrong data"
    ]


def test_other_fields_do_no_harm_where_no_installed_package_uses_them(tmp_path: Path):
    service = copied(tmp_path, "std_srvs") / "srv/Trigger.srv"
    service.write_text("bool really\n" + service.read_text())
    assert warnings(tmp_path) == []
