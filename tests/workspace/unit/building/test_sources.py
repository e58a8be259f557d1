"""Packages are found and ordered as by colcon."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from launcher.workspace.building import sources
from launcher.workspace.building.sources import manifest as manifests
from launcher.workspace.building.sources.source_text import SourceError
from tests.workspace.unit.building.source_tree import manifest, write


def names(folder: Path) -> list[str]:
    found = sources.find([str(folder)])
    assert found.errors == []
    return [package.name for package in found.packages]


def package(name: str, *dependencies: str, tag: str = "depend") -> dict[str, str]:
    tags = [f"<{tag}>{one}</{tag}>" for one in dependencies]
    cmake = f"cmake_minimum_required(VERSION 3.8)\nproject({name})\n"
    return {f"{name}/package.xml": manifest(name, *tags), f"{name}/CMakeLists.txt": cmake}


def test_packages_are_found_in_nested_folders_but_not_in_packages(tmp_path: Path):
    files = {**package("a"), "a/inner/package.xml": manifest("inner")}
    write(tmp_path / "stack" / "deep", files)
    write(tmp_path, {**package("b"), ".hidden/package.xml": manifest("hidden")})

    assert names(tmp_path) == ["a", "b"]


@pytest.mark.parametrize(
    ("text", "is_compiled", "has_interfaces"),
    [
        ("project(a)\n", True, False),
        ("project(a C)\nrosidl_generate_interfaces(a msg/A.msg)\n", True, True),
        ("project(a VERSION 1.0\n  LANGUAGES NONE)\n", False, False),
        ("PROJECT (a NONE)\n# include(x)\n", False, False),
        ("project(a NONE)\nenable_language(C)\n", True, False),
        ("# project(a NONE)\nproject(a)\n", True, False),
    ],
)
def test_what_a_package_needs_to_be_built(
    text: str, is_compiled: bool, has_interfaces: bool, tmp_path: Path
):
    write(tmp_path, {**package("a"), "a/CMakeLists.txt": text})
    (found,) = sources.find([str(tmp_path)]).packages

    assert (found.is_compiled, found.has_interfaces) == (is_compiled, has_interfaces)


@pytest.mark.parametrize("marker", ["COLCON_IGNORE", "AMENT_IGNORE", "CATKIN_IGNORE"])
def test_ignored_folders_are_left_out(tmp_path: Path, marker: str):
    write(tmp_path, {**package("a"), f"off/{marker}": ""})
    write(tmp_path / "off" / "below", package("b"))
    write(tmp_path, {**package("c"), f"c/{marker}": ""})

    assert names(tmp_path) == ["a"]


def test_links_are_followed_once(tmp_path: Path):
    write(tmp_path / "elsewhere", package("a"))
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "one").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "src" / "two").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "elsewhere" / "loop").symlink_to(tmp_path)

    assert names(tmp_path / "src") == ["a"]


def test_folders_without_package_xml_are_packages_too(tmp_path: Path):
    write(tmp_path, {"c/CMakeLists.txt": "# project(not_this)\nproject( plain_c )\n"})
    write(tmp_path, {"p/setup.py": "from setuptools import setup\nsetup(name='plain_python')\n"})
    write(tmp_path, {"q/setup.py": "import setuptools\nsetuptools.setup()\n"})
    write(tmp_path, {"q/setup.cfg": "[metadata]\nname = configured\n"})

    found = sources.find([str(tmp_path)]).packages

    types = [(one.name, one.build_type) for one in found]
    assert types == [("configured", "python"), ("plain_c", "cmake"), ("plain_python", "python")]


@pytest.mark.parametrize(
    ("tag", "kinds"),
    [
        ("depend", {"build", "run"}),
        ("build_depend", {"build"}),
        ("buildtool_depend", {"build"}),
        ("build_export_depend", {"run"}),
        ("exec_depend", {"run"}),
        ("test_depend", {"test"}),
    ],
)
def test_kinds_of_dependencies(tmp_path: Path, tag: str, kinds: set[str]):
    write(tmp_path, package("a", "b", tag=tag))

    (found,) = sources.find([str(tmp_path)]).packages

    (dependency,) = found.dependencies
    assert (dependency.name, {*dependency.kinds}, dependency.line) == ("b", kinds, 8)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # catkin_pkg uses old names
def test_conditions_and_format_2(tmp_path: Path):
    tags = (
        '<depend condition="$ROS_VERSION == 1">roscpp</depend>',
        '<depend condition="$ROS_VERSION == 2 and $MINE == yes">rclpy</depend>',
    )
    write(tmp_path, {"a/package.xml": manifest("a", *tags), "a/CMakeLists.txt": ""})
    write(tmp_path, {"b/package.xml": manifest("b", "<run_depend>x</run_depend>")})
    text = manifest("b", "<exec_depend>x</exec_depend>").replace('format="3"', 'format="2"')
    write(tmp_path, {"b/package.xml": text})

    first, second = sources.find([str(tmp_path)], {"MINE": "yes"}).packages

    assert [(one.name, one.line) for one in first.dependencies] == [("rclpy", 9)]
    assert [one.name for one in second.dependencies] == ["x"]


def test_order_is_by_dependencies_then_by_name(tmp_path: Path):
    write(tmp_path, {**package("a", "z"), **package("z"), **package("m"), **package("n", "a")})

    found = sources.find([str(tmp_path)]).packages

    assert [one.name for one in sources.in_order(found)] == ["m", "z", "a", "n"]
    assert sources.with_dependencies(found, ["n"]) == {"n", "a", "z"}
    assert sources.with_dependents(found, ["z"]) == {"n", "a", "z"}


def test_plain_packages_may_depend_on_each_other_in_a_cycle(tmp_path: Path):
    write(tmp_path, {"a/CMakeLists.txt": "project(a)\nfind_package(b)\n"})
    write(tmp_path, {"b/CMakeLists.txt": "project(b)\nfind_package(a)\n"})

    (tmp_path / "a" / "gone.cmake").symlink_to("nothing")

    (error,) = sources.cycles(sources.find([str(tmp_path)]).packages)

    assert error.where == str(tmp_path / "a")


def test_a_dependency_on_a_group_is_one_on_its_members(tmp_path: Path):
    member = manifest("z", "<member_of_group>interfaces</member_of_group>")
    user = manifest("a", "<group_depend>interfaces</group_depend>")
    write(tmp_path, {"z/package.xml": member, "a/package.xml": user})

    found = sources.find([str(tmp_path)]).packages

    assert [one.name for one in sources.in_order(found)] == ["z", "a"]


def test_a_dependency_cycle_is_reported_with_the_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    write(tmp_path, {**package("a", "b"), **package("b", "c", tag="test_depend")})
    write(tmp_path, {**package("c", "a", tag="exec_depend"), **package("d", "a")})

    with pytest.raises(SourceError) as raised:
        sources.in_order(sources.find(["."]).packages)

    assert raised.value.where == "a/package.xml:8"
    assert raised.value.message == "dependency cycle: a -> b -> c -> a"


def test_the_order_and_the_names_are_those_of_colcon(tmp_path: Path):
    write(tmp_path, {**package("a", "z"), **package("z"), **package("m", "a", tag="test_depend")})
    write(tmp_path, {"c/CMakeLists.txt": "project(plain)\ninclude(x/y.cmake)\n"})
    write(tmp_path, {"c/x/y.cmake": '# find_package(k)\nFIND_PACKAGE( "zlast" REQUIRED)\n'})
    write(tmp_path, {"d/CMakeLists.txt": "# größe\nproject(zlast)\n", "off/AMENT_IGNORE": ""})
    write(tmp_path / "off", package("b"))
    group = manifest("k", "<member_of_group>g</member_of_group>")
    write(tmp_path, {"k/package.xml": group, "k/CMakeLists.txt": "project(k)\n"})
    user = manifest("b", "<group_depend>g</group_depend>")
    write(tmp_path, {"b/package.xml": user, "b/CMakeLists.txt": "project(b)\n"})
    colcon = [sys.executable, "-m", "colcon", "--log-base", os.devnull, "list", "-t"]
    env = {**os.environ, "HOME": str(tmp_path), "COLCON_HOME": str(tmp_path)}
    listed = subprocess.run(colcon, cwd=tmp_path, env=env, capture_output=True, text=True)

    packages = sources.in_order(sources.find([str(tmp_path)]).packages)

    ours = [f"{one.name}\t{Path(one.folder).relative_to(tmp_path)}" for one in packages]
    assert ours == [line.rpartition("\t")[0] for line in listed.stdout.splitlines()]


def test_all_installed_package_xml_can_be_read():
    files = sorted(Path(sys.prefix).glob("share/*/package.xml"))

    names = [manifests.read(str(file), {}).name for file in files]

    assert len(names) > 50
    assert names == [file.parent.name for file in files]


def test_the_packages_are_known_without_what_building_needs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """`doctor` finds them where only rclpy and the launcher are installed."""
    monkeypatch.setitem(sys.modules, "catkin_pkg", None)
    condition = '<depend condition="$ROS_VERSION == 1">b</depend>'
    write(tmp_path, {"a/package.xml": manifest("a", condition), "a/CMakeLists.txt": ""})
    write(tmp_path, {"none/package.xml": "<package/>"})

    found = sources.find([str(tmp_path)])

    assert [(one.name, [two.name for two in one.dependencies]) for one in found.packages] == [
        ("a", ["b"])
    ]
    assert [error.message for error in found.errors] == ["package.xml has no <name>"]
