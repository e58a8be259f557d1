"""Which commands are Python programs of the interpreter of the tests."""

from __future__ import annotations

import os
import sys
import zipfile
from pathlib import Path

import pytest

from launcher.packages.python_program import PythonProgram, program_of

BIN = os.path.dirname(sys.executable)
ENV = {"PATH": f"{BIN}:/usr/bin:/bin"}


def script(folder: Path, first_line: str, name: str = "talker") -> str:
    path = folder / name
    path.write_text(f"{first_line}\nprint('hello')\n")
    path.chmod(0o755)
    return str(path)


def found(*argv: str, cwd: str | None = None) -> PythonProgram:
    program = program_of(argv, ENV, cwd)
    assert isinstance(program, PythonProgram), program
    return program


def reason(*argv: str) -> str:
    program = program_of(argv, ENV)
    assert isinstance(program, str)
    return program


def test_a_console_script_is_one(tmp_path: Path):
    path = script(tmp_path, f"#!{sys.executable}")
    program = found(path, "--ros-args", "-r", "x:=y")
    assert (program.script, program.words) == (path, ("--ros-args", "-r", "x:=y"))
    assert program.executed == path
    assert program.orig_argv == (sys.executable, path, "--ros-args", "-r", "x:=y")


def test_a_script_may_ask_env_for_the_interpreter(tmp_path: Path):
    path = script(tmp_path, "#!/usr/bin/env python3")
    program = found(path)
    assert program.interpreter == program.executed == f"{BIN}/python3"
    assert program.orig_argv == ("python3", path)


def test_the_interpreter_with_a_file_or_a_module_is_one(tmp_path: Path):
    path = script(tmp_path, "", "node.py")
    assert found(sys.executable, path, "1").script == path
    program = found("python3", "-m", "package.node", "-v")
    assert (program.module, program.words) == ("package.node", ("-v",))
    assert program.orig_argv == ("python3", "-m", "package.node", "-v")


def test_paths_are_those_of_its_working_directory(tmp_path: Path):
    script(tmp_path, f"#!{sys.executable}")
    assert found("./talker", cwd=str(tmp_path)).script == "./talker"
    assert "was not found" in reason("./talker")


@pytest.mark.parametrize("option", ["-u", "-O", "-I", "-cpass", "-Xdev"])
def test_options_of_the_interpreter_change_it(option: str):
    assert f"option '{option[:2]}' of the interpreter" in reason(sys.executable, option, "a.py")


@pytest.mark.parametrize(
    "line", ["#!/bin/sh", "#!", "#!/usr/bin/env -S python3 -u", "#!/usr/bin/env no-such"]
)
def test_scripts_of_something_else_are_not(tmp_path: Path, line: str):
    assert "'#!' line" in reason(script(tmp_path, line))


def test_an_option_in_the_first_line_changes_the_interpreter(tmp_path: Path):
    assert "'#!' line has '-E'" in reason(script(tmp_path, f"#!{sys.executable} -E"))


def test_another_environment_has_another_interpreter(tmp_path: Path):
    (tmp_path / "bin").mkdir()
    other = tmp_path / "bin/python"
    other.symlink_to(os.path.realpath(sys.executable))
    assert "is another interpreter" in reason(script(tmp_path, f"#!{other}"))


def test_prefixes_and_other_programs_are_not():
    assert reason("nice", sys.executable, "a.py") == "'nice' is not a Python script"
    assert reason("cat") == "'cat' is not a Python script"
    assert reason() == "it has no command"


def test_archives_and_missing_files_are_not(tmp_path: Path):
    archive = tmp_path / "app.pyz"
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("__main__.py", "print('hello')")
    assert "is not a text" in reason(sys.executable, str(archive))
    assert "cannot be read" in reason(sys.executable, "/no/such/file.py")
    assert "standard input" in reason(sys.executable)
