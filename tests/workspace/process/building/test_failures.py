"""What a user sees when packages have mistakes: from real colcon, CMake, rosidl and compilers."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from launcher.base.errors import ExitCode
from tests.workspace.process.building.small_packages import (
    build,
    cmake_package,
    files_package,
    python_package,
    write,
)

HIDDEN = "if(TRUE)\n  set(files msg/A.msg)\nendif()\nrosidl_generate_interfaces(m ${files})"
INTERFACES = (
    "<buildtool_depend>rosidl_default_generators</buildtool_depend>",
    "<member_of_group>rosidl_interface_packages</member_of_group>",
)


def interface_package(src: Path, call: str, **messages: str) -> None:
    """The package `m` with files in `msg/`."""
    lines = ("find_package(rosidl_default_generators REQUIRED)", call)
    folder = cmake_package(src, "m", *lines, languages="C CXX")
    manifest = folder / "package.xml"
    text = manifest.read_text(encoding="utf-8")
    manifest.write_text(text.replace("  <export>", "".join(INTERFACES) + "\n  <export>"))
    for name, text in messages.items():
        write(folder / "msg" / f"{name}.msg", text)


def test_mistakes_are_reported_before_anything_is_built(tmp_path: Path):
    python_package(tmp_path / "src", "right")
    cmake_package(tmp_path / "src", "cpp", "find_package(rclcpp REQUIRED)")
    interface_package(tmp_path / "src", "rosidl_generate_interfaces(m msg/A.msg)", A="int a\n")

    result = build(tmp_path)

    assert result.code == ExitCode.USAGE
    assert "error: src/cpp/CMakeLists.txt:4: rclcpp has no wheel" in result.err
    assert "error: src/m/msg/A.msg:1: unknown type 'int'\n    int a\n    ^\nhint: write int32" in (
        result.err
    )
    assert not (tmp_path / "install").exists()


@pytest.mark.thorough
def test_the_packages_without_mistakes_are_built_if_asked(tmp_path: Path):
    python_package(tmp_path / "src", "right")
    python_package(tmp_path / "src", "running", "cpp")
    files_package(tmp_path / "src", "building", depends=["cpp"])
    cmake_package(tmp_path / "src", "cpp", "find_package(rclcpp REQUIRED)")
    write(tmp_path / "src/unreadable/package.xml", "<package")

    result = build(tmp_path, "--keep-going")

    assert result.code == ExitCode.USAGE
    assert "5 packages: 2 built, 0 unchanged, 3 refused (building, cpp, unreadable)" in result.out
    assert (tmp_path / "install" / "right").is_dir()
    assert (tmp_path / "install" / "running").is_dir()


@pytest.mark.thorough
def test_a_failed_package_keeps_only_those_from_being_built_that_are_built_from_it(tmp_path: Path):
    cmake_package(tmp_path / "src", "failing", 'message(FATAL_ERROR "no")')
    files_package(tmp_path / "src", "building", depends=["failing"])
    python_package(tmp_path / "src", "running", "failing")
    python_package(tmp_path / "src", "above", "running")

    result = build(tmp_path)

    assert result.code == ExitCode.PROCESS_FAILED
    counts = "2 built, 0 unchanged, 1 failed (failing), 1 not tried (building)"
    assert result.summary == f"4 packages: {counts}"
    assert "error: src/failing/CMakeLists.txt:4: no\n" in result.err
    assert (tmp_path / result.err.split()[-1]).is_file()  # all of its output


@pytest.mark.thorough
@pytest.mark.parametrize("missing", [["b"], ["b", "c"]])
def test_a_package_that_needs_others_that_colcon_is_to_leave_out(
    tmp_path: Path, missing: list[str]
):
    for name in missing:
        cmake_package(tmp_path / "src", name)
    cmake_package(tmp_path / "src", "a", depends=missing)

    result = build(tmp_path, "--", "--packages-select", "a")

    others = "'b', which is" if missing == ["b"] else "'b', 'c', which are"
    assert result.code == ExitCode.PROCESS_FAILED
    assert f"error: 'a' needs {others} not built\nhint: build what it needs too" in result.err
    assert (tmp_path / result.err.split()[-1]).is_file()  # all of its output


@pytest.mark.thorough
def test_a_corrected_package_is_built_although_ninja_could_not_read_its_file(tmp_path: Path):
    """ninja runs CMake again, but only if it can read what CMake wrote before."""
    target = "add_custom_target({} ALL COMMAND true BYPRODUCTS same.txt)"
    cmake_package(tmp_path / "src", "p", target.format("a"))
    assert build(tmp_path).code == 0

    cmake_package(tmp_path / "src", "p", target.format("a"), target.format("b"))
    result = build(tmp_path)
    assert result.code == ExitCode.PROCESS_FAILED
    assert "error: src/p/CMakeLists.txt: two targets make the same file, same.txt" in result.err

    cmake_package(tmp_path / "src", "p", target.format("a"))
    assert build(tmp_path).code == 0


def test_a_failing_setup_py_is_reported_with_its_line(tmp_path: Path):
    folder = python_package(tmp_path / "src", "p")
    setup = folder / "setup.py"
    setup.write_text("version = 1 / 0\n" + setup.read_text(encoding="utf-8"))

    result = build(tmp_path)

    assert result.code == ExitCode.PROCESS_FAILED
    assert result.err.startswith(
        "error: src/p/setup.py:1: ZeroDivisionError: division by zero\n    version = 1 / 0\n"
    )
    assert "Traceback" not in result.err
    log = tmp_path / result.err.rstrip().rpartition(" ")[2]
    assert log.is_file()


@pytest.mark.thorough
def test_an_error_of_cmake_is_reported_in_the_file_of_the_user(tmp_path: Path):
    """Not in the macro of another package that has noticed it."""
    call = "add_custom_target(m)\nrosidl_generate_interfaces(m msg/A.msg)"
    interface_package(tmp_path / "src", call, A="int32 a\n")

    result = build(tmp_path)

    assert result.code == ExitCode.PROCESS_FAILED
    assert result.err.startswith("error: src/m/CMakeLists.txt:6: add_custom_target cannot create")


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("int32 a\nint b\n", "unknown type 'int'"),
        ("int32 a\nFoo b\n", "unknown type 'Foo', or its file is not listed"),
        ("int32 a\nint32 class\n", "'class' is a keyword of C or C++"),
    ],
)
def test_a_message_that_only_cmake_finds(tmp_path: Path, text: str, message: str):
    """It is listed under a condition, which the checks before the build do not evaluate."""
    interface_package(tmp_path / "src", HIDDEN, A=text)

    result = build(tmp_path)

    assert result.code == ExitCode.PROCESS_FAILED
    assert result.err.startswith(f"error: src/m/msg/A.msg:2: {message}")


@pytest.mark.thorough
@pytest.mark.parametrize("compiler", ["system", "zig"])
def test_a_compiler_error_is_reported_with_its_line(tmp_path: Path, compiler: str):
    folder = cmake_package(tmp_path / "src", "c", "add_executable(go src/go.c)", languages="C CXX")
    write(folder / "src" / "go.c", "int main(void) {\n  return undeclared;\n}\n")

    result = build(tmp_path, "--compiler", compiler)

    assert result.code == ExitCode.PROCESS_FAILED
    assert result.err.startswith("error: src/c/src/go.c:2: ")
    assert "\n    return undeclared;\n           ^\n" in result.err


@pytest.mark.thorough
def test_a_failure_is_explained_in_any_language(tmp_path: Path):
    """Linkers translate their messages, if the translation is installed."""
    folder = cmake_package(tmp_path / "src", "c", "add_executable(go src/go.c)", languages="C CXX")
    write(folder / "src" / "go.c", "int missing(void);\nint main(void) { return missing(); }\n")
    env = {**os.environ, "LC_ALL": "C.UTF-8", "LANGUAGE": "fr"}

    result = build(tmp_path, "--compiler", "system", env=env)

    assert result.code == ExitCode.PROCESS_FAILED
    assert result.err.startswith("error: src/c/src/go.c:2: nothing defines missing, which is used")


@pytest.mark.thorough
def test_a_file_to_install_is_reported_although_cmake_stops_without_a_place(tmp_path: Path):
    lines = "if(TRUE)\n  install(FILES config/none.yaml DESTINATION share/c)\nendif()"
    cmake_package(tmp_path / "src", "c", lines)

    result = build(tmp_path, "--copy")

    assert result.code == ExitCode.PROCESS_FAILED
    assert "error: src/c/CMakeLists.txt:5: '" in result.err
    assert "none.yaml' is to be installed, and does not exist" in result.err


@pytest.mark.thorough
def test_a_program_in_plain_c_is_built(tmp_path: Path):
    """The checks refuse libraries of ROS 2, not compiled programs."""
    folder = cmake_package(
        tmp_path / "src",
        "c",
        "add_executable(go src/go.c)\ninstall(TARGETS go DESTINATION lib/${PROJECT_NAME})",
        languages="C CXX",
    )
    write(folder / "src" / "go.c", "int main(void) { return 0; }\n")

    result = build(tmp_path)

    assert (result.code, result.err) == (0, "")
    assert (tmp_path / "install" / "c" / "lib" / "c" / "go").is_file()
