"""What may be a mistake, or not, is a warning: a check refuses only what certainly fails."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.workspace.building import checks, sources
from launcher.workspace.building.colcon import colcon_arguments as colcon_words
from tests.workspace.unit.building.source_tree import (
    INTERFACE_TAGS,
    MINIMUM,
    interface_package,
    manifest,
    python_package,
    write,
)

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")

FIND = (
    "find_package(ament_cmake REQUIRED)\nfind_package(rosidl_default_generators REQUIRED)\n"
    "find_package(std_msgs REQUIRED)\n"
)
TAKE = "bool now\n---\nbool done\n"


def interfaces(call: str, **files: str) -> dict[str, str]:
    """The interface package `m`; the names of `files` have no suffix: `msg/A`."""
    texts = {f"{path}.{path.partition('/')[0]}": text for path, text in files.items()}
    cmake = f"{MINIMUM}project(m)\n{FIND}{call}\nament_package()\n"
    return interface_package("m", texts, cmake=cmake)


def cmake(text: str, *tags: str, **files: str) -> dict[str, str]:
    """The package `c` with this CMakeLists.txt, behind the head, and further files."""
    texts = {"package.xml": manifest("c", *tags), "CMakeLists.txt": f"{MINIMUM}{text}", **files}
    return {f"c/{path}": content for path, content in texts.items()}


def needing(name: str, *needed: str, find: str = "") -> dict[str, str]:
    tags = [f"<depend>{one}</depend>" for one in needed]
    text = f"{MINIMUM}project({name})\nfind_package(ament_cmake REQUIRED)\n{find}ament_package()\n"
    return {f"{name}/package.xml": manifest(name, *tags), f"{name}/CMakeLists.txt": text}


def setup(before: str = "", **changes: str) -> dict[str, str]:
    """The package `p`; `changes` are replaced in setup.py."""
    text = python_package("p")["p/setup.py"]
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    head, call, rest = text.partition("setup(")
    return python_package("p", setup_py=f"{head}{before}{call}{rest}")


# Name -> files, and a part of the warning; "" where there is nothing to warn about.
CASES: dict[str, tuple[dict[str, str], str]] = {
    # ---- interface files
    "services in a subfolder": (
        interfaces(
            "rosidl_generate_interfaces(m srv/Other.srv srv/calibration/Take.srv)",
            **{"srv/calibration/Take": TAKE, "srv/Other": TAKE},
        ),
        "",
    ),
    "services in a subfolder only": (
        interfaces(
            "find_package(service_msgs REQUIRED)\nrosidl_generate_interfaces(m "
            "srv/calibration/Take.srv DEPENDENCIES service_msgs)",
            **{"srv/calibration/Take": TAKE},
        ),
        "",
    ),
    "messages in subfolders": (
        interfaces(
            "rosidl_generate_interfaces(m msg/low/Leaf.msg msg/high/Tree.msg)",
            **{"msg/low/Leaf": "int8 a", "msg/high/Tree": "Leaf[] leaves\nm/Leaf first"},
        ),
        "",
    ),
    "messages in a folder of another name": (
        {
            **interfaces("rosidl_generate_interfaces(m schemas/A.msg schemas/B.msg)"),
            "m/schemas/A.msg": "int8 a",
            "m/schemas/B.msg": "A a",
        },
        "",
    ),
    "files that only CMake knows": (
        interfaces(
            "rosidl_generate_interfaces(m ${basic_MSG_FILES} action/Go.action)",
            **{"action/Go": "m/Basic goal\n---\n---\n"},
        ),
        "'m/Basic' is none of the types that are known before CMake runs",
    ),
    "a macro that may list more": (
        interfaces(
            "add_more_interfaces(m)\nrosidl_generate_interfaces(m msg/A.msg)",
            **{"msg/A": "Basic b"},
        ),
        "'Basic' is none of the types",
    ),
    "a file that is made": (
        interfaces(
            "configure_file(A.msg.in ${CMAKE_CURRENT_SOURCE_DIR}/msg/A.msg)\n"
            "rosidl_generate_interfaces(m msg/A.msg)"
        ),
        "the interface file 'msg/A.msg' does not exist",
    ),
    "a package of the workspace whose interfaces only CMake knows": (
        {
            **needing("low", find="include(generated.cmake)\n"),
            **interfaces(
                "find_package(low REQUIRED)\nrosidl_generate_interfaces(m msg/A.msg "
                "DEPENDENCIES low)",
                **{"msg/A": "low/Leaf leaf"},
            ),
            "m/package.xml": manifest("m", *INTERFACE_TAGS, "<depend>low</depend>"),
        },
        "low has no message 'Leaf'",
    ),
    "DEPENDENCIES that only CMake knows": (
        interfaces(
            "rosidl_generate_interfaces(m msg/A.msg DEPENDENCIES ${UNKNOWN})",
            **{"msg/A": "geometry_msgs/Point p"},
        ),
        "",
    ),
    "DEPENDENCIES and generators that another package brings": (
        {
            **needing("tool", find="configure_tool()\n"),
            **interface_package(
                "m",
                {"msg/A.msg": "geometry_msgs/Point p"},
                cmake=f"{MINIMUM}project(m)\nfind_package(tool REQUIRED)\n"
                "rosidl_generate_interfaces(m msg/A.msg DEPENDENCIES geometry_msgs)\n"
                "ament_package()\n",
                tags=("<depend>tool</depend>",),
            ),
        },
        "needs find_package(rosidl_default_generators REQUIRED) before it",
    ),
    "types of a package that may be elsewhere": (
        interfaces(
            "set(far_msgs_DIR /opt/far)\nfind_package(far_msgs REQUIRED)\n"
            "rosidl_generate_interfaces(m msg/A.msg DEPENDENCIES far_msgs)",
            **{"msg/A": "far_msgs/Point p"},
        ),
        "package 'far_msgs' is neither in the workspace nor in the environment",
    ),
    "a keyword of C++20": (
        interfaces("rosidl_generate_interfaces(m msg/A.msg)", **{"msg/A": "int8 concept"}),
        "'concept' is a keyword of C++20",
    ),
    "IDL of any name": (
        {
            **interfaces("rosidl_generate_interfaces(m msg/low.idl)"),
            "m/msg/low.idl": "module m { module msg { struct low { int32 a; }; }; };",
        },
        "'low' is not a valid name of an interface",
    ),
    # ---- package.xml
    "any tags in export": (
        {
            **needing("c"),
            "c/package.xml": manifest("c").replace(
                "<build_type>", "<build_types/><builds_type x='1'>a<b/></builds_type><build_type>"
            ),
        },
        "",
    ),
    "plain CMake without a build type": (
        {
            "c/package.xml": manifest("c", build_type="catkin"),
            "c/CMakeLists.txt": f"{MINIMUM}project(c)\nfind_package(catkin QUIET)\n",
        },
        "",
    ),
    # ---- find_package
    "a dependency that another dependency names": (
        {
            **needing("a"),
            **needing("b", "a"),
            **needing("c", "b", find="find_package(a REQUIRED)\n"),
        },
        "",
    ),
    "an installed package that is in the workspace, too": (
        {**needing("std_srvs"), **needing("c", find="find_package(std_srvs REQUIRED)\n")},
        "package.xml does not name 'std_srvs' as a dependency",
    ),
    **{
        f"a package that may be elsewhere: {text!r}": (
            cmake(
                f"project(c)\nfind_package(ament_cmake REQUIRED)\n{text}\nament_package()\n",
                "<depend>nav_driver</depend>",
                **{"cmake/more.cmake": "# CMAKE_PREFIX_PATH\n"},
            ),
            "package 'nav_driver' is neither in the workspace nor in the environment",
        )
        for text in (
            "list(APPEND CMAKE_PREFIX_PATH /opt/driver)\nfind_package(nav_driver REQUIRED)",
            "set(nav_driver_DIR /opt/driver)\nfind_package(nav_driver REQUIRED)",
            "find_package(nav_driver REQUIRED PATHS /opt/driver)",
            "list(APPEND CMAKE_MODULE_PATH /opt/modules)\nfind_package(nav_driver REQUIRED)",
        )
    },
    "a module of a package that is needed": (
        {
            **needing("vendor"),
            "vendor/cmake/Modules/Findnav_driver.cmake": "",
            **needing("c", "vendor", find="find_package(nav_driver REQUIRED)\n"),
        },
        "",
    ),
    # ---- other commands
    "another name of a project without ament_package": (
        cmake("project(other)\ninstall(FILES package.xml DESTINATION share/c)\n"),
        "project() is called 'other', package.xml 'c'",
    ),
    "a second project": (
        cmake("project(other)\nproject(c)\nfind_package(ament_cmake REQUIRED)\nament_package()\n"),
        "",
    ),
    "a file to install that is made": (
        cmake(
            "project(c)\nfind_package(ament_cmake REQUIRED)\nadd_custom_command(OUTPUT made.txt)\n"
            "install(FILES made.txt DESTINATION share/c)\nament_package()\n"
        ),
        "the file 'made.txt' to install does not exist",
    ),
    "a file to install on request": (
        cmake(
            "project(c)\nfind_package(ament_cmake REQUIRED)\n"
            "install(FILES made.txt DESTINATION share/c EXCLUDE_FROM_ALL)\nament_package()\n"
        ),
        "",
    ),
    # ---- setup.py
    "a data file that is made": (
        setup(
            "open('made.xml', 'w').close()\n",
            **{"['package.xml']": "['package.xml', 'made.xml']"},
        ),
        "the file 'made.xml' in data_files does not exist",
    ),
    "a call of setup in a condition": (
        setup("if False:\n  ", **{"['package.xml']": "['packages.xml']"}),
        "the file 'packages.xml' in data_files does not exist",
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_it_is_not_refused(name: str, tmp_path: Path):
    files, warning = CASES[name]
    write(tmp_path, files)

    found = checks.check(sources.find([str(tmp_path)]))

    assert [one.render() for one in checks.errors(found)] == []
    messages = [one.message for one in found]
    assert any(warning in one for one in messages) if warning else messages == []


@pytest.mark.parametrize(
    "words",
    [
        ["--cmake-args", "-DCMAKE_PREFIX_PATH=/opt/driver"],
        ["--cmake-args", "-D", "-DCMAKE_TOOLCHAIN_FILE:PATH=x"],
        ["--ament-cmake-args=-Dnav_driver_DIR=/opt/driver"],
    ],
)
def test_definitions_for_cmake_may_say_where_a_package_is(words: list[str], tmp_path: Path):
    write(tmp_path, needing("c", "nav_driver", find="find_package(nav_driver REQUIRED)\n"))
    found = sources.find([str(tmp_path)])

    assert len(checks.errors(checks.check(found))) == 1
    names = colcon_words.definitions(words)
    assert checks.errors(checks.check(found, definitions=names)) == []


def test_in_a_merged_installation_the_order_of_packages_may_be_right(tmp_path: Path):
    write(tmp_path, {**needing("a"), **needing("c", find="find_package(a REQUIRED)\n")})
    found = sources.find([str(tmp_path)])

    assert len(checks.errors(checks.check(found))) == 1
    assert checks.errors(checks.check(found, is_merged=True)) == []
