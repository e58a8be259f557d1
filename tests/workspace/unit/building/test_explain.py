"""Failures of colcon's steps as one message: from outputs recorded from the real tools.

`recorded/` has the outputs; {folder}, {build} and {prefix} stand for the sources of the package,
its build folder, and the environment.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pytest

from launcher.base.program import program
from launcher.packages.distribution import or_default
from launcher.workspace.building import build_report
from launcher.workspace.building.explain import BuildOutput, explain
from tests.workspace.unit.building.source_tree import python_package, write

RECORDED = Path(__file__).with_name("recorded")


class Case(NamedTuple):
    """The package's files; `at` is the text that the caret points to, "" without one."""

    files: dict[str, str]
    where: str | None
    at: str
    message: str
    hint: str | None = None


def cmake(line: int, command: str, message: str, hint: str | None = None, text: str = "") -> Case:
    """A CMakeLists.txt with one command in this line."""
    cmake_text = "\n" * (line - 1) + (text or f"{command}(...)") + "\n"
    where = f"CMakeLists.txt:{line}"
    return Case({"CMakeLists.txt": cmake_text}, where, command, message, hint)


def cpp(text: str, line: int, at: str, message: str, hint: str | None = None) -> Case:
    return Case({"src/go.cpp": text}, f"src/go.cpp:{line}", at, message, hint)


def setup(old: str, new: str, line: int, at: str, message: str, hint: str | None = None) -> Case:
    texts = python_package("p")
    text = texts["p/setup.py"].replace(old, new)
    return Case({"setup.py": text}, f"setup.py:{line}", at, message, hint)


def interface(
    path: str, text: str, line: int, at: str, message: str, hint: str | None = None
) -> Case:
    return Case({path: text}, f"{path}:{line}", at, message, hint)


SYNTAX = "#include <cstdio>\n\nint main()\n{\n  int count = 3\n  return cout;\n}\n"
TEMPLATE = (
    "#include <vector>\n#include <algorithm>\nstruct X {};\nint main() {\n"
    "  std::vector<X> v;\n  std::sort(v.begin(), v.end());\n}\n"
)
LINK = "int missing(int);\nint main() { return missing(1); }\n"
OWN_HEADER = {
    "src/go.cpp": '#include "tools.hpp"\nint main() {}\n',
    "include/tools.hpp": "#pragma once\ninline int f() { return undeclared; }\n",
}
RCLCPP = "#include <rclcpp/rclcpp.hpp>\nint main() {}\n"
RCLCPP_MESSAGE = "rclcpp has no wheel: C++ nodes need an installation of ROS 2"
RCLCPP_HINT = f"build this package where ROS 2 is installed (apt install ros-{or_default()}-rclcpp)"
LINK_MESSAGE = "nothing defines missing(int), which is used here"
LINK_HINT = "add the file or library that has it: add_executable() or target_link_libraries()"

CASES = {
    # ---- CMake
    "cmake_custom": Case(
        {"CMakeLists.txt": ""},
        None,
        "",
        "a command failed: {prefix}/lib/python3.11/site-packages/cmake/data/bin/cmake -E false",
    ),
    "cmake_custom2": Case(
        {"gen.py": "def make():\n    raise ValueError('no input')\n\nmake()\n"},
        "gen.py:2",
        "",
        "ValueError: no input",
    ),
    "cmake_fatal": cmake(5, "message", "this needs a reason"),
    "cmake_find": cmake(
        4,
        "find_package",
        "CMake does not find the package 'Foo'",
        "install it with its CMake files, or say where they are: launcher build -- --cmake-args "
        "-DFoo_DIR=FOLDER",
    ),
    "cmake_find_lib": cmake(
        4, "find_library", "Could not find X_LIB using the following names: not_there"
    ),
    "cmake_include": Case(
        {"cmake/tools.cmake": "\n  target_link_libraries(nothing x)\n", "CMakeLists.txt": ""},
        "cmake/tools.cmake:2",
        "target_link_libraries",
        'Cannot specify link libraries for target "nothing" which is not built by this project',
    ),
    "cmake_install": cmake(
        4,
        "lanch",
        "'{folder}/lanch' is to be installed, and does not exist",
        text="set(D ${CMAKE_CURRENT_SOURCE_DIR}/lanch)",
    ),
    "cmake_same_output": Case(
        {"CMakeLists.txt": ""},
        "CMakeLists.txt",
        "",
        "two targets make the same file, rosidl_generator_c/m/msg/http_get.h",
        "is something listed twice?",
    ),
    "cmake_parse": Case(
        {"cmake/tools.cmake": "message(STATUS x\n", "CMakeLists.txt": ""},
        "cmake/tools.cmake:1",
        "",
        'Parse error.  Function missing ending ")".  End of file reached.',
    ),
    "cmake_pkgconfig": cmake(
        5, "pkg_check_modules", "The following required packages were not found: libnothere"
    ),
    "cmake_source": cmake(4, "add_executable", "Cannot find source file: src/nothing.cpp"),
    "cmake_unknown": cmake(
        4,
        "add_exectuable",
        "CMake has no command 'add_exectuable'",
        "did you mean 'add_executable'?",
    ),
    # ---- compilers and linkers
    "cpp_syntax": cpp(SYNTAX, 6, "return", "expected ‘,’ or ‘;’ before ‘return’"),  # noqa: RUF001
    "cpp_syntax_zig": cpp(SYNTAX, 5, "", "expected ';' at end of declaration"),
    "cpp_header": cpp(RCLCPP, 1, "<rclcpp", RCLCPP_MESSAGE, RCLCPP_HINT),
    "cpp_header_zig": cpp(RCLCPP, 1, "<rclcpp", RCLCPP_MESSAGE, RCLCPP_HINT),
    "cpp_interfaces": cpp(
        RCLCPP.replace("rclcpp/rclcpp.hpp", "low/msg/leaf.hpp"),
        1,
        "<low",
        "low has no interfaces for C++: 'low/msg/leaf.hpp' does not exist",
        f"`{program()} build --cpp` generates those of the workspace",
    ),
    "cpp_own_header": Case(
        OWN_HEADER,
        "include/tools.hpp:2",
        "undeclared",
        "‘undeclared’ was not declared in this scope",  # noqa: RUF001
    ),
    "cpp_own_header_zig": Case(
        OWN_HEADER, "include/tools.hpp:2", "undeclared", "use of undeclared identifier 'undeclared'"
    ),
    "cpp_template": cpp(
        TEMPLATE,
        6,
        "(v.begin",
        "no match for ‘operator<’ (operand types are ‘X’ and ‘X’)",  # noqa: RUF001
    ),
    "cpp_template_zig": cpp(
        TEMPLATE,
        6,
        "sort(v",
        "invalid operands to binary expression ('const X' and 'const X')",
    ),
    "cpp_link": cpp(LINK, 2, "missing(1)", LINK_MESSAGE, LINK_HINT),
    "cpp_link_zig": cpp(LINK, 2, "missing(1)", LINK_MESSAGE, LINK_HINT),
    # ---- setup.py
    "py_no_setup": Case(
        {"setup.py": "from setuptools import setup\n\n\ndef main():\n    setup(name='p')\n"},
        "setup.py:5",
        "setup(",
        "setup.py does not give the metadata of the package",
        "it has to call setup() whenever it runs",
    ),
    "py_name": setup("'0.1.0'", "VERSION", 5, "", "NameError: name 'VERSION' is not defined"),
    "py_import": setup(
        "from setuptools",
        "import not_there\nfrom setuptools",
        1,
        "",
        "ModuleNotFoundError: No module named 'not_there'",
    ),
    "py_raise": setup(
        "\nsetup(",
        "\nwith open('VERSION') as f:\n    version = f.read()\nsetup(",
        3,
        "",
        "FileNotFoundError: [Errno 2] No such file or directory: 'VERSION'",
    ),
    "py_data": setup(
        "['package.xml']",
        "[*['nothing.yaml']]",
        9,
        "nothing.yaml",
        "the file 'nothing.yaml' in data_files does not exist",
    ),
    "py_pkg": setup(
        "find_packages(exclude=['test'])",
        "[*['nothing']]",
        6,
        "nothing",
        "the Python package 'nothing' does not exist",
    ),
    "py_arg": setup(
        "'0.1.0'", "'not a version'", 3, "", "InvalidVersion: Invalid version: 'not a version'"
    ),
    "py_entry": setup(
        "'talker = ",
        "*['talker'], 'x = ",
        3,
        "setup(",
        "setuptools: Pair.__new__() missing 1 required positional argument: 'value'",
    ),
    "py_syntax": setup(
        "'0.1.0',", "'0.1.0'", 5, "", "SyntaxError: invalid syntax. Perhaps you forgot a comma?"
    ),
    # ---- rosidl
    "ros_cond": interface(
        "msg/A.msg", "int32 a\nint b\n", 2, "int b", "unknown type 'int'", "write int32"
    ),
    "ros_idl": interface(
        "msg/A.idl",
        "module ros_idl { module msg {\n struct A { long c };\n}; };\n",
        2,
        "};",
        "not understood as IDL",
        "is a ';' missing before it?",
    ),
    "ros_kw": interface(
        "msg/LongName.msg",
        "int32 a\nint32 default\n",
        2,
        "default",
        "'default' is a keyword of C or C++: the generated code could not be compiled",
        "use another name, for example 'default_value'",
    ),
    "ros_pkg": interface(
        "msg/A.msg",
        "int32 a\ngeometry_msgs/Point b\n",
        2,
        "geometry_msgs",
        "'geometry_msgs' is missing in the DEPENDENCIES of rosidl_generate_interfaces",
    ),
    "ros_type": interface(
        "msg/A.msg",
        "int32 a\nFoo b\n",
        2,
        "Foo",
        "unknown type 'Foo', or its file is not listed",
    ),
    "ros_target": cmake(
        6,
        "rosidl_generate_interfaces",
        'add_custom_target cannot create target "ros_target" because another target with the same '
        "name already exists.  The existing target is a custom target created in source directory "
        '"{folder}".',
    ),
    # ---- the machine
    "disk_full": Case(
        {"src/go.cpp": ""},
        None,
        "",
        "No space left on device: build/full/sm.o",
        "make space and repeat the command: what is built already is kept",
    ),
    "disk_full_generator": Case(
        {"src/go.cpp": ""},
        None,
        "",
        "No space left on device: build",
        "make space and repeat the command: what is built already is kept",
    ),
    "killed": Case(
        {"src/go.cpp": ""},
        None,
        "",
        "the compiler was killed: there was too little memory",
        "build one package at a time, with one compiler: MAKEFLAGS=-j1 launcher build -- "
        "--executor sequential",
    ),
}


def output_of(name: str, folder: Path) -> BuildOutput:
    text = (RECORDED / f"{name}.txt").read_text(encoding="utf-8")
    for key, path in (("folder", folder), ("build", folder / "build"), ("prefix", "/prefix")):
        text = text.replace(f"{{{key}}}", str(path))
    return BuildOutput(name, str(folder), str(folder / "build"), text)


@pytest.mark.parametrize("name", CASES)
def test_a_failure_is_one_message(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    case = CASES[name]
    monkeypatch.chdir(tmp_path)
    write(tmp_path, case.files)

    error = explain(output_of(name, tmp_path))

    assert error is not None
    message = case.message.format(folder=tmp_path, prefix="/prefix") if "{" in case.message else ""
    assert (error.message, error.where, error.hint) == (
        message or case.message,
        case.where,
        case.hint,
    )
    if case.at:
        assert error.source_line is not None
        assert error.column is not None
        assert error.source_line[error.column - 1 :].startswith(case.at)


def test_every_recorded_output_is_used():
    without_cause = {"py_exit"}  # says what it wants to say, without a place
    assert {path.stem for path in RECORDED.glob("*.txt")} == {*CASES} | without_cause


@pytest.mark.parametrize(
    "text",
    [
        "cc1plus: fatal error: error writing to /tmp/cc1.s: No space left on device",
        "OSError: [Errno 28] No space left on device: '/tmp/cc1.s'",
        "cp: error writing '/tmp/cc1.s': No space left on device",
        "/tmp/cc1.s: Disk quota exceeded",
    ],
)
def test_the_file_for_which_a_disk_has_no_space_is_named(tmp_path: Path, text: str):
    error = explain(BuildOutput("p", str(tmp_path), str(tmp_path / "build"), text))
    assert error is not None
    assert error.message == "No space left on device: /tmp/cc1.s"


def test_an_unknown_output_is_not_explained(tmp_path: Path):
    assert (
        explain(BuildOutput("p", str(tmp_path), str(tmp_path), "this package needs Windows"))
        is None
    )
    assert explain(BuildOutput("p", str(tmp_path), str(tmp_path), "")) is None


def test_a_file_is_known_by_its_real_path_and_in_any_encoding(tmp_path: Path):
    sources = tmp_path / "real" / "src" / "p"
    sources.mkdir(parents=True)
    (sources / "go.cpp").write_bytes("// größe\nint x = y;\n".encode("latin-1"))
    (tmp_path / "link").symlink_to("real")
    folder, text = tmp_path / "link" / "src" / "p", f"{sources}/go.cpp:2:9: error: no y\n"

    error = explain(BuildOutput("p", str(folder), str(tmp_path / "link" / "build" / "p"), text))

    assert error is not None
    assert (error.where, error.source_line) == (f"{folder}/go.cpp:2", "int x = y;")


def test_the_place_is_known_although_the_file_is_gone(tmp_path: Path):
    """The user may have removed it in the meantime: then there is no line to show."""
    error = explain(output_of("cpp_syntax", tmp_path))

    assert error is not None
    assert error.where == f"{tmp_path}/src/go.cpp:6"
    assert error.source_line is None


def test_sources_that_were_removed_during_the_build_are_not_explained(tmp_path: Path):
    assert explain(output_of("py_pkg", tmp_path / "gone")) is None


def test_what_colcon_drops_is_asked_for_again(tmp_path: Path):
    setup_py = "print('before')\nraise ValueError('no \\u00fcmlaut')\n"
    write(tmp_path, {"setup.py": setup_py, "log/stdout_stderr.log": "Traceback\n"})
    log = tmp_path / "log" / "stdout_stderr.log"
    assert build_report.output_of(str(tmp_path), str(log.parent), "") == "Traceback\n"

    log.write_text("in _get_setup_information\nsubprocess.CalledProcessError: Command ...\n")
    text = build_report.output_of(str(tmp_path), str(log.parent), "")

    assert text.startswith("before\n")
    assert "ValueError: no ümlaut" in text


def test_without_a_log_there_is_what_was_written_to_stderr(tmp_path: Path):
    assert (
        build_report.output_of(str(tmp_path), str(tmp_path / "none"), "from stderr")
        == "from stderr"
    )
