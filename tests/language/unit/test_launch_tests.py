"""Tests of launch_testing and launch_pytest that are given to the launcher as launch files."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.base.errors import ExitCode
from launcher.cli.dispatch import main

DESCRIPTION = (
    "from launch import LaunchDescription\n\n\ndef {}():\n    return LaunchDescription([])\n"
)
TEST = DESCRIPTION.format("generate_test_description")
Said = tuple[int, str]


@pytest.fixture
def said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]):
    """What `plan` of a file says on standard error, and its exit code."""
    monkeypatch.chdir(tmp_path)
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
        "import launch_testing.asserts\nimport launch_testing_ros.actions\n",
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
    assert hint == f"hint: run it with python -m launcher launch-test {Path.cwd()}/a.launch.py"


def test_a_test_of_launch_pytest_is_named(said):
    code, errors = said("import launch_pytest\n")
    assert code == ExitCode.USAGE
    assert (
        ": it is a test of launch_pytest, not a launch file\n    import launch_pytest\n" in errors
    )
    assert "hint: run it with python -m pytest " in errors


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
