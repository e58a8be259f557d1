"""Mistakes in package.xml."""

from __future__ import annotations

from tests.workspace.unit.building.mistakes.cases import ABSENT, CMAKE, SOURCES, Case
from tests.workspace.unit.building.source_tree import MINIMUM, manifest, python_package


def xml(
    text: str, line: int, at: str, message: str, hint: str | None, *, cmake: bool = True
) -> Case:
    files = {"p/package.xml": text}
    if cmake:
        files["p/CMakeLists.txt"] = CMAKE.format("p") + "ament_package()\n"
    return Case(files, f"src/p/package.xml:{line}", at, message, hint)


ERRORS = {
    "an empty package.xml": xml("", 1, "", "the file is empty", None),
    "an open tag": xml(
        "<package>\n  <name>p</nam>\n</package>",
        2,
        "nam>",
        "mismatched tag",
        "<name> in line 2 is not closed",
    ),
    "an ampersand": xml(
        "<package>\n  <name>p & q</name>\n</package>",
        2,
        " q<",
        "not well-formed (invalid token)",
        "write &amp; for a literal '&'",
    ),
    "an unknown tag": xml(
        manifest("p", "<depends>std_msgs</depends>"),
        8,
        "<depends>",
        "unknown tag <depends>",
        "did you mean 'depend'?",
    ),
    "run_depend in format 3": xml(
        manifest("p", "<run_depend>x</run_depend>"),
        8,
        "<run_depend>",
        "<run_depend> does not exist in format 3",
        "write <exec_depend>x</exec_depend>",
    ),
    "an address that catkin_pkg refuses": xml(
        manifest("p").replace("someone@example.org", "a@b.c"),
        6,
        "<maintainer",
        'Invalid email "a@b.c" for person "Someone"',
        "write it as NAME@HOST.DOMAIN, where DOMAIN has two or more letters",
    ),
    "a missing version": xml(
        manifest("p").replace("  <version>0.1.0</version>\n", ""),
        2,
        "<package",
        'The manifest must contain exactly one "version" tag',
        "add <version>0.1.0</version>",
    ),
    "a wrong version": xml(
        manifest("p").replace("0.1.0", "0.1"),
        4,
        "<version>",
        'Package version "0.1" does not follow version conventions',
        None,
    ),
    "a condition": xml(
        manifest("p", '<depend condition="$A = 1">x</depend>'),
        8,
        "condition=",
        "the condition '$A = 1' cannot be understood",
        'write for example condition="$ROS_VERSION == 2"',
    ),
    "no build type, and no CMakeLists.txt": xml(
        manifest("p").replace("<build_type>ament_cmake</build_type>", ""),
        9,
        "",
        "package.xml has no build type, which means ROS 1 (catkin)",
        "add <export><build_type>ament_cmake</build_type></export>",
        cmake=False,
    ),
    "a package of ROS 1": Case(
        {
            "p/package.xml": manifest("p", build_type="catkin"),
            "p/CMakeLists.txt": f"{MINIMUM}project(p)\nfind_package(catkin REQUIRED)\n",
        },
        "src/p/package.xml:8",
        "catkin",
        "a package of ROS 1 cannot be built with ROS 2",
        "keep it out of the build: touch src/p/COLCON_IGNORE",
    ),
    "build_type outside of export": xml(
        manifest("p", "<build_type>ament_cmake</build_type>"),
        8,
        "<build_type>",
        "<build_type> belongs into <export>",
        "write <export><build_type>ament_cmake</build_type></export>",
    ),
    "an unknown build type": xml(
        manifest("p", build_type="ament_make"),
        8,
        "ament_make",
        "unknown build type 'ament_make'",
        "did you mean 'ament_cmake'?",
    ),
    "without CMakeLists.txt": xml(
        manifest("p"),
        8,
        "ament_cmake",
        "a package of build type ament_cmake has a CMakeLists.txt, which is missing",
        None,
        cmake=False,
    ),
    "without setup.py": xml(
        manifest("p", build_type="ament_python"),
        8,
        "ament_python",
        "a package of build type ament_python has a setup.py, which is missing",
        "write ament_cmake: there is a CMakeLists.txt",
    ),
    "two packages of one name": Case(
        {**python_package("p"), **{f"q/{k}": v for k, v in python_package("p").items()}},
        "src/q/p/package.xml:3",
        "p</name>",
        "two packages are called 'p', the other one is src/p",
        "rename one of them, or keep one out of the build with an empty file src/q/p/COLCON_IGNORE",
    ),
    "a dependency cycle": Case(
        {
            **python_package("a", "<depend>b</depend>"),
            **python_package("b", "<exec_depend>a</exec_depend>"),
        },
        "src/a/package.xml:8",
        "b</depend>",
        "dependency cycle: a -> b -> a",
        "remove one of these dependencies, or move what both need into a separate package",
    ),
}

WARNINGS = {
    "no build type": xml(
        manifest("p").replace("<build_type>ament_cmake</build_type>", ""),
        9,
        "",
        "package.xml has no build type, which means ROS 1 (catkin)",
        "add <export><build_type>ament_cmake</build_type></export>",
    ),
    "a dependency that is missing": Case(
        python_package("p", "<depend>rclpi</depend>"),
        "src/p/package.xml:8",
        "rclpi",
        ABSENT.format("rclpi"),
        "did you mean 'rclpy'?",
    ),
    "a name that is a part of its tag": Case(
        python_package("p", "<depend>epe</depend>"),
        "src/p/package.xml:8",
        "epe</depend>",
        ABSENT.format("epe"),
        SOURCES.format("epe"),
    ),
    "a misspelt dependency to run": Case(
        python_package("p", "<exec_depend>geometry_msg</exec_depend>"),
        "src/p/package.xml:8",
        "geometry_msg",
        ABSENT.format("geometry_msg"),
        "did you mean 'geometry_msgs'?",
    ),
}
