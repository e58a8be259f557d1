"""Packages that are right, written in the ways of public repositories, have no problems."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from launcher.workspace.building import checks, sources
from tests.workspace.unit.building.source_tree import (
    MINIMUM,
    interface_package,
    manifest,
    python_package,
    write,
)

HEAD = """\
# A comment with a ( and a "quotation mark
cmake_minimum_required(VERSION 3.8)
project( m  VERSION 1.0 LANGUAGES CXX )
#[[ a comment
in brackets ( ]]
if(CMAKE_COMPILER_IS_GNUCXX OR CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  add_compile_options(-Wall -Wextra -Wpedantic)
endif()
FIND_PACKAGE(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)
find_package(std_msgs REQUIRED)
"""
TAIL = """
if(BUILD_TESTING)
  find_package(ament_lint_auto REQUIRED)
  ament_lint_auto_find_test_dependencies()
endif()
ament_export_dependencies(rosidl_default_runtime)
ament_package()
"""

CALLS = {
    "names": """
        rosidl_generate_interfaces(${PROJECT_NAME} "msg/A.msg" srv/B.srv DEPENDENCIES std_msgs)""",
    "variables": """
        set(msg_files
          "msg/A.msg"  # with a comment
        )
        list(APPEND all ${msg_files})
        list(APPEND all srv/B.srv)
        rosidl_generate_interfaces(m ${all} DEPENDENCIES std_msgs ADD_LINTER_TESTS)""",
    "empty DEPENDENCIES": """
        rosidl_generate_interfaces(${PROJECT_NAME} msg/A.msg srv/B.srv LIBRARY_NAME m DEPENDENCIES
          std_msgs builtin_interfaces)""",
    "patterns": """
        file(GLOB msgs RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} msg/*.msg)
        file(GLOB srvs RELATIVE "${CMAKE_CURRENT_SOURCE_DIR}" "srv/*.srv")
        rosidl_generate_interfaces(m ${msgs} ${srvs} DEPENDENCIES std_msgs)""",
    "a loop over patterns": """
        file(GLOB FOUND CONFIGURE_DEPENDS msg/*.msg srv/*.srv)
        foreach(one IN LISTS FOUND)
          string(REPLACE "${CMAKE_CURRENT_SOURCE_DIR}/" "" relative ${one})
          list(APPEND STRIPPED ${relative})
        endforeach()
        rosidl_generate_interfaces(m ${STRIPPED} DEPENDENCIES std_msgs)""",
    "a condition": """
        set(files msg/A.msg)
        if(WITH_SERVICES)
          list(APPEND files srv/B.srv)
        endif()
        rosidl_generate_interfaces(m ${files} DEPENDENCIES std_msgs)""",
    "a list that begins empty": """
        set(files "")
        list(APPEND files msg/A.msg "srv/B.srv;")
        rosidl_generate_interfaces(m ${files} DEPENDENCIES std_msgs)""",
    "lists as text": """
        set(files "msg/A.msg;srv/B.srv")
        rosidl_generate_interfaces(m "${files}" "${NO}" DEPENDENCIES "std_msgs;")""",
    "another value under a condition": """
        set(folder messages)
        if(TRUE)
          set(folder msg)
        endif()
        rosidl_generate_interfaces(m ${folder}/A.msg srv/B.srv DEPENDENCIES std_msgs)""",
    "a macro of the file": """
        macro(add_message name)
          list(APPEND files msg/${name}.msg)
        endmacro()
        set(files)
        add_message(A)
        rosidl_generate_interfaces(m ${files} srv/B.srv DEPENDENCIES std_msgs)""",
    "a command under a condition": """
        set(files)
        if(TRUE)
          string(CONCAT files msg/ A.msg)
        endif()
        rosidl_generate_interfaces(m ${files} srv/B.srv DEPENDENCIES std_msgs)""",
    "an included file": """
        set(files)
        include(cmake/files.cmake)
        rosidl_generate_interfaces(m ${files} srv/B.srv DEPENDENCIES std_msgs)""",
    "an early end": """
        if(NOT rclcpp_FOUND)
          rosidl_generate_interfaces(m msg/A.msg srv/B.srv DEPENDENCIES std_msgs)
          return()
        endif()
        find_package(rclcpp REQUIRED)""",
    "an early end of a loop": """
        foreach(file A C)
          if(file STREQUAL C)
            continue()
          endif()
          list(APPEND files msg/${file}.msg)
        endforeach()
        rosidl_generate_interfaces(m ${files} srv/B.srv DEPENDENCIES std_msgs)""",
    "patterns below the folder of the file": """
        file(GLOB msgs LIST_DIRECTORIES false RELATIVE ${CMAKE_CURRENT_LIST_DIR}
          ${CMAKE_CURRENT_LIST_DIR}/msg/*.msg)
        file(GLOB srvs RELATIVE ${UNKNOWN} ${UNKNOWN}/srv/*.srv)
        rosidl_generate_interfaces(m ${msgs} ${srvs} DEPENDENCIES std_msgs)""",
    "packages that only CMake knows": """
        foreach(package IN LISTS UNKNOWN)
          find_package(${package} REQUIRED)
        endforeach()
        rosidl_generate_interfaces(m msg/A.msg srv/B.srv DEPENDENCIES std_msgs geometry_msgs)""",
    "an unknown command": """
        set(files nothing)
        find_my_files(files)
        rosidl_generate_interfaces(m ${files} DEPENDENCIES std_msgs)""",
    "a folder and a path": """
        rosidl_generate_interfaces(m "${CMAKE_CURRENT_SOURCE_DIR}:msg/A.msg" srv/B.srv
          DEPENDENCIES std_msgs)""",
    "a loop of packages": """
        set(PACKAGES builtin_interfaces geometry_msgs)
        foreach(package ${PACKAGES})
          find_package(${package} REQUIRED)
        endforeach()
        rosidl_generate_interfaces(m msg/A.msg srv/B.srv DEPENDENCIES std_msgs ${PACKAGES})""",
    "things to install": """
        find_package(Threads REQUIRED)
        find_package(Python3 REQUIRED COMPONENTS Interpreter)
        find_package(of_the_system_only CONFIG REQUIRED)
        find_package(rclcpp QUIET)
        install(DIRECTORY msg srv DESTINATION share/${PROJECT_NAME}/ PATTERN "*.bak" EXCLUDE)
        install(DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/made DESTINATION share)
        install(FILES generated.txt DESTINATION share OPTIONAL)
        install(PROGRAMS $<TARGET_FILE:x> DESTINATION lib)
        rosidl_generate_interfaces(m msg/A.msg srv/B.srv DEPENDENCIES std_msgs)""",
}

A = """\
# All that is allowed.
std_msgs/Header header
builtin_interfaces/Time[<=3] times   # through std_msgs
int8\tb
string<=10[3] names ["a", 'b', "c, d"]
string text "with # no comment"
wstring<=5 w
float64[] numbers [1.0, 2e3, -.5]
bool ok true
byte b1 255
char c 97
int32 LIMIT=0x7F
string TEXT = "a=b"
float32 PI=3.14
uint64 big 18446744073709551615

    # an indented comment
int8 self
int8 size
"""


@pytest.mark.parametrize("call", CALLS)
def test_interfaces(call: str, tmp_path: Path):
    files = {"msg/A.msg": A, "srv/B.srv": "A a\n---\n"}
    package = interface_package("m", files, cmake=HEAD + CALLS[call] + TAIL)
    write(tmp_path, package)

    found = checks.check(sources.find([str(tmp_path)]))

    assert [one.render() for one in found] == []


@pytest.mark.parametrize(
    "head",
    [
        "project(m)\ncmake_minimum_required(VERSION 3.5)\n",
        "cmake_minimum_required(VERSION 2.8...3.14 FATAL_ERROR)\nproject(m)\n",
        "cmake_minimum_required(VERSION ${UNKNOWN})\nproject(m)\n",
        "cmake_policy(VERSION 3.8)\nproject(m)\n",
    ],
)
def test_places_of_policies(head: str, tmp_path: Path):
    cmake = HEAD[HEAD.index("#[[") :] + CALLS["names"] + TAIL
    files = {"msg/A.msg": A, "srv/B.srv": "A a\n---\n"}
    write(tmp_path, interface_package("m", files, cmake=head + cmake))

    assert checks.check(sources.find([str(tmp_path)])) == []


def test_types_of_a_package_whose_files_only_cmake_knows(tmp_path: Path):
    head = "find_package(ament_cmake REQUIRED)\nfind_package(rosidl_default_generators REQUIRED)\n"
    first = (
        f"{MINIMUM}project(first)\n{head}if(TRUE)\n  set(files msg/Leaf.msg)\nendif()\n"
        "rosidl_generate_interfaces(first ${files})\nament_package()\n"
    )
    second = (
        f"{MINIMUM}project(second)\n{head}find_package(first REQUIRED)\n"
        "rosidl_generate_interfaces(second msg/Tree.msg DEPENDENCIES first)\nament_package()\n"
    )
    tree, depend = {"msg/Tree.msg": "first/Leaf[] leaves"}, ("<depend>first</depend>",)
    write(tmp_path, interface_package("first", {"msg/Leaf.msg": "int8 a"}, cmake=first))
    write(tmp_path, interface_package("second", tree, cmake=second, tags=depend))

    found = checks.check(sources.find([str(tmp_path)]))

    assert [one.render() for one in found] == []


def test_ament_cmake_auto(tmp_path: Path):
    """It looks for all packages that package.xml names."""
    auto = ("<buildtool_depend>ament_cmake_auto</buildtool_depend>",)
    cmake = (
        f"{MINIMUM}project(m)\nfind_package(ament_cmake_auto REQUIRED)\n"
        "ament_auto_find_build_dependencies()\n"
        "rosidl_generate_interfaces(m msg/A.msg DEPENDENCIES std_msgs)\nament_auto_package()\n"
    )
    write(tmp_path, interface_package("m", {"msg/A.msg": "int8 a"}, cmake=cmake, tags=auto))
    tool = (
        f"{MINIMUM}project(ament_cmake_auto)\nfind_package(ament_cmake REQUIRED)\nament_package()\n"
    )
    write(tmp_path / "tool", {"CMakeLists.txt": tool, "package.xml": manifest("ament_cmake_auto")})

    found = checks.check(sources.find([str(tmp_path)]))

    assert [one.render() for one in found] == []


def test_packages_of_plain_cmake(tmp_path: Path):
    """colcon builds first what they look for, and takes their name from package.xml if any."""
    files = {"dds/package.xml": manifest("dds", "<depend>pcap</depend>", build_type="cmake")}
    files["dds/CMakeLists.txt"] = "project(DDS)\nfind_package(pcap REQUIRED)\n"
    files["dds/cmake/modules/Findpcap.cmake"] = ""
    files["user/CMakeLists.txt"] = "project(user)\nfind_package(library REQUIRED)\n"
    files["bare/CMakeLists.txt"] = "add_custom_target(nothing)\n"
    files["library/CMakeLists.txt"] = "project(library)\nfind_package(dds QUIET)\n"
    files["c/package.xml"] = manifest("c", "<depend>installed</depend>")
    files["c/CMakeLists.txt"] = (
        f"{MINIMUM}# größe\nproject(c)\nfind_package(ament_cmake REQUIRED)\n"
        "find_package(dds QUIET)\nfind_package(installed REQUIRED)\nament_package()\n"
    )
    write(tmp_path / "src", files)
    cmake = tmp_path / "src/c/CMakeLists.txt"
    cmake.write_bytes(cmake.read_text(encoding="utf-8").encode("latin-1"))
    write(tmp_path / "conda", {"lib/cmake/Installed-1.0/installedConfig.cmake": ""})
    env = {**os.environ, "PATH": f"{tmp_path}/conda/bin:/usr/bin"}

    found = checks.check(sources.find([str(tmp_path / "src")]), env)

    (warning,) = [one.message for one in found]
    assert warning == "package 'pcap' is neither in the workspace nor in the environment"
    assert checks.errors(found) == []


def test_other_packages(tmp_path: Path):
    tags = (
        "<depend>rclpy</depend>",
        "<depend>python3-numpy</depend>",
        "<depend>yaml-cpp</depend>",
        "<exec_depend>ros2launch</exec_depend>",
        "<exec_depend>robot_state_publisher</exec_depend>",
        "<test_depend>ament_copyright</test_depend>",
        "<test_depend>python3-pytest</test_depend>",
        "<doc_depend>rosdoc</doc_depend>",
        '<depend condition="$ROS_VERSION == 1">roscpp</depend>',
    )
    setup = """\
        import os
        from glob import glob
        from setuptools import setup

        package_name = 'p'

        setup(
            name=package_name,
            version='0.0.0',
            packages=[package_name],
            data_files=[
                ('share/ament_index/resource_index/packages', ['resource/' + package_name]),
                ('share/' + package_name, ['package.xml']),
                (os.path.join('share', package_name, 'launch'), glob('launch/*.py')),
                (os.path.join('', ''), []),
                (f'share/{package_name}', glob('urdf/*')),
            ],
            entry_points={'console_scripts': [f'talker = {package_name}.talker:main [extra]']},
        )
        """
    cfg = "[develop]\nscript-dir: $base/lib/p\n[install]\ninstall-scripts=${base}/lib/p\n"
    write(tmp_path, python_package("p", *tags, setup_py=setup, setup_cfg=cfg))
    given = """\
        from catkin_pkg.python_setup import generate_distutils_setup
        from setuptools import setup
        name = 'other'
        name = name.replace('other', 'q')
        setup(name=name, **generate_distutils_setup(packages=['nothing']))
        """
    write(tmp_path, python_package("q", setup_py=given))
    bringup = (
        "cmake_minimum_required(VERSION 3.8)\nproject(b NONE)\nfind_package(ament_cmake REQUIRED)\n"
        "install(DIRECTORY launch/ config DESTINATION share/b)\nament_package()\n"
    )
    write(tmp_path, {"b/package.xml": manifest("b"), "b/CMakeLists.txt": bringup})
    write(tmp_path, {"b/launch/x.launch.py": "", "b/config/x.yaml": ""})
    write(tmp_path, {"plain/CMakeLists.txt": "project(plain C)\nadd_executable(x x.c)\n"})
    only = f"{MINIMUM}project(n)\nfind_package(rosidl_default_generators REQUIRED)\n"
    only += "rosidl_generate_interfaces(n msg/N.msg)\nament_package()\n"
    write(tmp_path, interface_package("n", {"msg/N.msg": "int8 n"}, cmake=only))

    found = checks.check(sources.find([str(tmp_path)]))

    assert [one.render() for one in found] == []


def test_types_of_another_package_of_the_workspace(tmp_path: Path):
    first = interface_package("first", {"msg/Leaf.msg": "std_msgs/Header h"})
    cmake = (
        f"{MINIMUM}project(second)\nfind_package(ament_cmake REQUIRED)\n"
        "find_package(rosidl_default_generators REQUIRED)\nfind_package(first REQUIRED)\n"
        "rosidl_generate_interfaces(second msg/Tree.msg DEPENDENCIES first)\nament_package()\n"
    )
    text = "first/Leaf[] leaves\nstd_msgs/Header header\nbuiltin_interfaces/Time t\n"
    depend = ("<depend>first</depend>",)
    second = interface_package("second", {"msg/Tree.msg": text}, cmake=cmake, tags=depend)
    write(tmp_path, first | second)

    found = checks.check(sources.find([str(tmp_path)]))

    assert [one.render() for one in found] == []


def test_an_older_build_does_not_count_as_installed(tmp_path: Path):
    """A package that is only in the workspace's install/ cannot be depended on."""
    index = "install/gone/share/ament_index/resource_index/packages/gone"
    write(tmp_path, {index: "", "install/gone/share/gone/cmake/goneConfig.cmake": ""})
    cmake = (
        f"{MINIMUM}project(c)\nfind_package(gone REQUIRED)\nfind_package(ament_cmake REQUIRED)\n"
    )
    xml = manifest("c", "<depend>gone</depend>")
    write(tmp_path / "src", {"c/package.xml": xml, "c/CMakeLists.txt": cmake + "ament_package()\n"})
    old = f"{tmp_path}/install/gone"
    env = {"AMENT_PREFIX_PATH": old, "CMAKE_PREFIX_PATH": old, "PATH": f"{old}/bin"}
    found = sources.find([str(tmp_path / "src")])

    with_install = checks.check(found, env, install=str(tmp_path / "install"))

    assert checks.check(found, env) == []
    assert [one.message for one in with_install] == [
        "package 'gone' is neither in the workspace nor in the environment"
    ]


@pytest.mark.parametrize(
    "setup_py",
    [
        "import setuptools\nsetuptools.setup(name='p')\n",
        "import setuptools\ngetattr(setuptools, 'setup')(name='p')\n",
        "from setuptools import setup as build\nbuild(name='p')\n",
        "from setuptools import setup\nbuild = setup\nbuild(name='p')\n",
        "from skbuild import build\nbuild()\n",
        "import helper\n",
        "exec(open('real_setup.py').read())\n",
        "import runpy\nrunpy.run_path('other.py')\n",
    ],
)
def test_setup_may_be_called_in_any_way(setup_py, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path, python_package("p", setup_py=setup_py))

    assert checks.errors(checks.check(sources.find(["."]))) == []
