"""Tests of launch_testing and launch_pytest that are given to the launcher as launch files."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from launcher.base.errors import ExitCode
from launcher.cli.dispatch import main

DESCRIPTION = (
    "from launch import LaunchDescription\n\n\ndef {}():\n    return LaunchDescription([])\n"
)
TEST = DESCRIPTION.format("generate_test_description")
OWN = "python -m launcher smoke, or the pytest fixture launched_system"
NEEDED = " (ROS 2's package launch_testing)"
Said = tuple[int, str]


@pytest.fixture
def said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]):
    """What `plan` of a file says on standard error, and its exit code; without `launch_test`."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.syspath_prepend(str(tmp_path))

    def plan(text: str) -> Said:
        Path("a.launch.py").write_text(text)
        return main(["plan", "a.launch.py"]), capfd.readouterr().err

    return plan


@pytest.mark.parametrize(
    "head",
    [
        "",
        "import launch_testing.actions\n",
        "from launch_testing.markers import keep_alive\n\n\n@keep_alive\n",
    ],
)
def test_a_test_description_is_named_with_the_program_that_runs_it(said, head: str):
    text = TEST.replace("\n\n\ndef", f"\n{head}def")
    line = text.splitlines().index("def generate_test_description():") + 1
    code, errors = said(text)
    assert code == ExitCode.USAGE
    first, _, caret, hint = errors.splitlines()
    assert first == (
        f"error: {Path.cwd()}/a.launch.py:{line}: generate_test_description() makes it a test of "
        "launch_testing, not a launch file"
    )
    assert caret.index("^") == 4 + len("def ")
    assert hint == (
        f"hint: run it with launch_test {Path.cwd()}/a.launch.py{NEEDED}; without launch_testing: "
        f"{OWN}"
    )


def test_a_program_that_is_there_is_not_asked_for(said, tmp_path: Path):
    program = tmp_path / "bin" / "launch_test"
    program.parent.mkdir()
    program.touch()
    os.chmod(program, 0o755)
    _, errors = said(TEST)
    assert f"hint: run it with launch_test {tmp_path}/a.launch.py; without" in errors


@pytest.mark.parametrize(
    ("module", "program"),
    [
        ("launch_testing.asserts", "launch_test"),
        ("launch_testing_ros", "launch_test"),
        ("launch_testing_ros.actions", "launch_test"),
        ("launch_pytest", "pytest"),
        ("launch_pytest.tools", "pytest"),
    ],
)
def test_a_missing_package_of_tests_is_no_misspelt_module(said, module: str, program: str):
    code, errors = said(f"import {module}\n{TEST}")
    top = module.partition(".")[0]
    needed = f"(ROS 2's package {top})"
    assert code == ExitCode.USAGE
    assert "did you mean" not in errors
    assert f"hint: run tests of {top} with {program} FILE {needed}; without {top}: {OWN}" in errors


def test_a_test_of_launch_pytest_is_named_where_that_is_installed(said, tmp_path: Path):
    (tmp_path / "launch_pytest.py").touch()
    code, errors = said("import launch_pytest\n")
    assert code == ExitCode.USAGE
    assert (
        ": it is a test of launch_pytest, not a launch file\n    import launch_pytest\n" in errors
    )
    assert "hint: run it with pytest " in errors


def test_a_file_with_both_functions_is_a_launch_file(said):
    both = TEST + DESCRIPTION.format("generate_launch_description")
    assert said(both) == (ExitCode.OK, "")


@pytest.mark.parametrize(
    ("module", "hint"),
    [
        ("lanch", "did you mean 'launch'?"),
        ("launch_rose", "did you mean 'launch_ros'?"),
        ("jsn", "did you mean 'json'?"),
        ("_jso", "did you mean '_json'?"),
        ("xpytest", "did you mean 'pytest'?"),
    ],
)
def test_a_misspelt_module_is_not_taken_for_the_launcher_or_a_private_one(said, module, hint):
    assert f"hint: {hint}\n" in said(f"import {module}\n")[1]
