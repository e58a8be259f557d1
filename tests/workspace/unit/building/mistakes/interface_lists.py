"""Mistakes in calls of rosidl_generate_interfaces, and in what a package of interfaces declares."""

from __future__ import annotations

from tests.workspace.unit.building.mistakes.cases import ABSENT, CMAKE, FIELD, Case, msg
from tests.workspace.unit.building.source_tree import INTERFACE_TAGS, interface_package, manifest


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


NOT_RECURSIVE = "refer to others by a number or a name: not even an array may hold the same type"

ERRORS = {
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
}

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
}
