"""Mistakes in CMakeLists.txt."""

from __future__ import annotations

from launcher.packages.distribution import or_default
from tests.workspace.unit.building.mistakes.cases import ABSENT, CMAKE, SOURCES, Case
from tests.workspace.unit.building.source_tree import MINIMUM, interface_package, manifest


def cmake(
    body: str, line: int, at: str, message: str, hint: str | None, *tags: str, **more: str
) -> Case:
    """An ament_cmake package `c`; its CMakeLists.txt goes on with `body` in line 4."""
    files = {
        "c/package.xml": manifest("c", *tags),
        "c/CMakeLists.txt": CMAKE.format("c") + body + "ament_package()\n",
        **{f"c/{path}": text for path, text in more.items()},
    }
    return Case(files, f"src/c/CMakeLists.txt:{line}", at, message, hint)


CPP = "{} has no wheel: C++ nodes need an installation of ROS 2"
OLD_CMAKE = "with a CMake before 3.3 the macros of ament and rosidl do not work"
CPP_HINT = f"build this package where ROS 2 is installed (apt install ros-{or_default()}-{{}})"

ERRORS = {
    "rclcpp": cmake(
        "find_package(rclcpp REQUIRED)\n",
        4,
        "rclcpp",
        CPP.format("rclcpp"),
        CPP_HINT.format("rclcpp"),
        "<depend>rclcpp</depend>",
    ),
    "rclcpp in a loop": cmake(
        "set(DEPS\n  rclcpp_components\n)\n"
        "foreach(one IN LISTS DEPS)\n  find_package(${one} REQUIRED)\nendforeach()\n",
        5,
        "rclcpp_components",
        CPP.format("rclcpp_components"),
        CPP_HINT.format("rclcpp-components"),
        "<depend>rclcpp_components</depend>",
    ),
    "a misspelt package to find": cmake(
        "find_package(sensor_msg REQUIRED)\n",
        4,
        "sensor_msg",
        ABSENT.format("sensor_msg"),
        "did you mean 'sensor_msgs'?",
        "<depend>sensor_msgs</depend>",
    ),
    "an unknown package": cmake(
        "find_package(my_driver REQUIRED)\n",
        4,
        "my_driver",
        ABSENT.format("my_driver"),
        SOURCES.format("my-driver"),
        "<depend>my_driver</depend>",
    ),
    "a package of the workspace that package.xml does not name": Case(
        {
            **interface_package("m", {"msg/A.msg": "int8 a"}),
            "c/package.xml": manifest("c"),
            "c/CMakeLists.txt": CMAKE.format("c") + "find_package(m REQUIRED)\nament_package()\n",
        },
        "src/c/CMakeLists.txt:4",
        "m REQUIRED",
        "package.xml does not name 'm' as a dependency: colcon may build it later",
        "add <depend>m</depend> to package.xml",
    ),
    "no project": Case(
        {
            "c/package.xml": manifest("c"),
            "c/CMakeLists.txt": CMAKE.replace("project({})\n", "") + "ament_package()\n",
        },
        "src/c/CMakeLists.txt",
        "",
        "CMakeLists.txt has no project()",
        "add project(c) as the second line",
    ),
    "no cmake_minimum_required": Case(
        interface_package(
            "m",
            {"msg/A.msg": "int8 a"},
            cmake=CMAKE.replace(MINIMUM, "").format("m")
            + "find_package(rosidl_default_generators REQUIRED)\n"
            "rosidl_generate_interfaces(m msg/A.msg)\nament_package()\n",
        ),
        "src/m/CMakeLists.txt",
        "",
        "CMakeLists.txt has no cmake_minimum_required()",
        "add cmake_minimum_required(VERSION 3.8) as the first line",
    ),
    "the policies of an old CMake": Case(
        interface_package(
            "m",
            {"msg/A.msg": "int8 a"},
            cmake=CMAKE.replace("3.8", "2.8.3").format("m")
            + "find_package(rosidl_default_generators REQUIRED)\n"
            "rosidl_generate_interfaces(m msg/A.msg)\nament_package()\n",
        ),
        "src/m/CMakeLists.txt:1",
        "VERSION",
        OLD_CMAKE,
        "write cmake_minimum_required(VERSION 3.8)",
    ),
    "another project": Case(
        {
            "c/package.xml": manifest("c"),
            "c/CMakeLists.txt": CMAKE.format("other") + "ament_package()\n",
        },
        "src/c/CMakeLists.txt:2",
        "other",
        "project() is called 'other', package.xml 'c'",
        "write project(c)",
    ),
    "an open parenthesis": cmake(
        "install(DIRECTORY launch\n",
        4,
        "install",
        "the '(' of install is not closed",
        None,
    ),
    "an open quotation mark": cmake(
        'set(x "abc)\n', 4, '"abc', "the text in quotation marks is not closed", None
    ),
    "a folder to install": cmake(
        "install(DIRECTORY\n  lanch\n  DESTINATION share/${PROJECT_NAME})\n",
        5,
        "lanch",
        "the folder 'lanch' to install does not exist",
        "did you mean 'launch'?",
        **{"launch/a.launch.py": ""},
    ),
    "a file to install": cmake(
        "install(PROGRAMS scripts/go.py DESTINATION lib/${PROJECT_NAME})\n",
        4,
        "scripts/go.py",
        "the file 'scripts/go.py' to install does not exist",
        "did you mean 'got.py'?",
        **{"scripts/got.py": ""},
    ),
    "a command of another package without find_package": cmake(
        "",
        3,
        "ament_python_install_package",
        "ament_python_install_package() needs find_package(ament_cmake REQUIRED) before it",
        None,
    )._replace(
        files={
            "c/package.xml": manifest("c"),
            "c/CMakeLists.txt": f"{MINIMUM}project(c)\nament_python_install_package(c)\n"
            "ament_package()\n",
        }
    ),
}

WARNINGS = {
    "no ament_package": Case(
        {"c/package.xml": manifest("c"), "c/CMakeLists.txt": CMAKE.format("c")},
        "src/c/CMakeLists.txt:3",
        "",
        "CMakeLists.txt does not end with ament_package(): the package is not found after it is "
        "built",
        "add ament_package() as the last line",
    ),
    "no cmake_minimum_required": Case(
        {
            "c/package.xml": manifest("c"),
            "c/CMakeLists.txt": CMAKE.replace(MINIMUM, "").format("c") + "ament_package()\n",
        },
        "src/c/CMakeLists.txt",
        "",
        "CMakeLists.txt has no cmake_minimum_required()",
        "add cmake_minimum_required(VERSION 3.8) as the first line",
    ),
    "the policies of an old CMake": Case(
        {
            "c/package.xml": manifest("c"),
            "c/CMakeLists.txt": CMAKE.replace("3.8", "3.1").format("c") + "ament_package()\n",
        },
        "src/c/CMakeLists.txt:1",
        "VERSION",
        OLD_CMAKE,
        "write cmake_minimum_required(VERSION 3.8)",
    ),
    "commands without find_package": Case(
        {
            "c/package.xml": manifest("c"),
            "c/CMakeLists.txt": f"{MINIMUM}project(c)\nament_package()\n",
        },
        "src/c/CMakeLists.txt:3",
        "ament_package",
        "ament_package() needs find_package(ament_cmake REQUIRED) before it",
        None,
    ),
}
