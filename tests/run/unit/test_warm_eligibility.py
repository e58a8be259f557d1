"""Which processes may be started warm."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from launcher.base.model.spec import ProcessSpec
from launcher.packages.python_program import PythonProgram
from launcher.run.warm.eligibility import Prepared, folder_of, judge, obstacle

BASE = {"PATH": "/usr/bin", "PYTHONUNBUFFERED": "1", "ROS_DOMAIN_ID": "1", "LD_LIBRARY_PATH": "/a"}
PREPARED = Prepared(["ROS_PYTHON_CHECK_FIELDS"], ["rclpy", "queue"], [])


def spec(*argv: str, shell: bool = False) -> ProcessSpec:
    return ProcessSpec(name="a-1", label="a", argv=argv, env=BASE, shell=shell)


def why_not(tmp_path: Path, **changes: str) -> str | None:
    return obstacle(str(tmp_path), {**BASE, **changes}, BASE, PREPARED)


def test_a_program_of_this_interpreter_may_be_forked(tmp_path: Path):
    (tmp_path / "node.py").touch()
    program = judge(spec(sys.executable, f"{tmp_path}/node.py", "-r"), BASE, "/")
    assert isinstance(program, PythonProgram)
    assert program.words == ("-r",)


def test_a_shell_and_a_prefix_may_not():
    assert judge(spec(sys.executable, "-m", "x", shell=True), BASE, "/") == "a shell runs it"
    assert "is not a Python script" in str(judge(spec("/usr/bin/nice", "python"), BASE, "/"))


@pytest.mark.parametrize("variable", ["COVERAGE_PROCESS_START", "COV_CORE_SOURCE"])
def test_under_coverage_nothing_is_forked(variable: str):
    env = {**BASE, variable: "x"}
    assert judge(spec(sys.executable, "-m", "x"), env, "/") == f"{variable} is set"


def test_a_missing_folder_is_reported_by_a_cold_start(tmp_path: Path):
    program = judge(spec(sys.executable, "-m", "x"), BASE, f"{tmp_path}/missing")
    assert program == f"'{tmp_path}/missing' is no folder"


def test_a_relative_search_path_depends_on_the_folder():
    env = {**BASE, "PYTHONPATH": "/a:b"}
    assert "relative" in str(judge(spec(sys.executable, "-m", "x"), env, "/"))


@pytest.mark.parametrize(
    "variable",
    ["PYTHONOPTIMIZE", "LD_PRELOAD", "RMW_IMPLEMENTATION", "OMP_NUM_THREADS", "LC_ALL", "TZ"],
)
def test_what_is_read_before_the_program_begins_must_be_equal(tmp_path: Path, variable: str):
    assert why_not(tmp_path, **{variable: "x"}) == (
        f"its {variable} is not that of what was prepared"
    )


def test_what_is_missing_is_not_equal_either(tmp_path: Path):
    env = {name: value for name, value in BASE.items() if name != "LD_LIBRARY_PATH"}
    assert "LD_LIBRARY_PATH" in str(obstacle(str(tmp_path), env, BASE, None))


def test_what_the_imports_have_read_must_be_equal(tmp_path: Path):
    assert "ROS_PYTHON_CHECK_FIELDS" in str(why_not(tmp_path, ROS_PYTHON_CHECK_FIELDS="1"))


@pytest.mark.parametrize("variable", ["ROS_DOMAIN_ID", "ROS_LOG_DIR", "RCUTILS_COLORIZED_OUTPUT"])
def test_what_is_read_later_may_differ(tmp_path: Path, variable: str):
    assert why_not(tmp_path, **{variable: "x"}) is None


@pytest.mark.parametrize("name", ["queue.py", "queue.cpython-311-x86_64-linux-gnu.so", "rclpy/"])
def test_a_module_in_its_folder_may_hide_one_that_was_prepared(tmp_path: Path, name: str):
    if name.endswith("/"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").touch()
    else:
        (tmp_path / name).touch()
    assert "hides" in str(why_not(tmp_path))


@pytest.mark.parametrize("name", ["node.py", "queue.txt", "queue.md", "rclpy"])
def test_other_files_in_its_folder_hide_nothing(tmp_path: Path, name: str):
    (tmp_path / name).touch()
    assert why_not(tmp_path) is None


def test_the_folder_of_a_script_is_that_of_the_file_it_links_to(tmp_path: Path):
    (tmp_path / "real").mkdir()
    (tmp_path / "real/node.py").touch()
    os.symlink(tmp_path / "real/node.py", tmp_path / "link")
    program = judge(spec(sys.executable, "link"), BASE, str(tmp_path))
    assert isinstance(program, str)  # judged in our own folder: the spec names none
    named = judge(spec(sys.executable, f"{tmp_path}/link"), BASE, "/")
    assert isinstance(named, PythonProgram)
    assert folder_of(named, "/") == f"{tmp_path}/real"
