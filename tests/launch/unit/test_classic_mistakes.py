"""Classic mistakes in launch files, one by one: sentence, line, caret, hint and exit code."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from pathlib import Path

import pytest

from launcher.base.errors import ExitCode
from launcher.cli.dispatch import main
from tests.launch.unit.classic_mistakes import conditions, includes, python_files, yaml_files
from tests.launch.unit.classic_mistakes.cases import HEAD, Case, described
from tests.launch.unit.classic_mistakes.tolerated import WARNINGS

TABLES = (python_files, conditions, includes, yaml_files)
ERRORS = {name: case for table in TABLES for name, case in table.ERRORS.items()}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with files to include, and log files in it only if something is started."""
    (tmp_path / "launch").mkdir()
    log = '<launch><arg name="count" default="1"/><log message="count $(var count)"/></launch>\n'
    for name in ("child.launch.xml", "launch/deep.launch.xml"):
        (tmp_path / name).write_text(log, encoding="utf-8")
    back = '<launch>\n  <include file="$(dirname)/case.launch.xml"/>\n</launch>\n'
    (tmp_path / "back.launch.xml").write_text(back, encoding="utf-8")
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "log"))
    yield tmp_path


def written(folder: Path, case: Case) -> Path:
    file = folder / f"case.launch.{case.suffix}"
    file.write_text(case.text, encoding="utf-8")
    return file


@pytest.mark.parametrize("verb", ["launch", "plan"])
@pytest.mark.parametrize("name", ERRORS)
def test_a_mistake_is_told_in_one_sentence_with_its_place_and_its_repair(
    name: str, verb: str, folder: Path, capfd: pytest.CaptureFixture[str]
):
    case = ERRORS[name]
    file = written(folder, case)

    code = main([verb, str(file), *case.words])

    head, source, caret, hint, *_ = capfd.readouterr().err.splitlines()
    message = case.message.replace("FOLDER", str(folder))
    assert code == ExitCode.USAGE
    assert head.replace("NameError: ", "").replace("AttributeError: ", "") == (
        f"error: {file}:{case.line}: {message}"
    )
    assert hint == "hint: " + case.hint.replace("FILE", str(file)).replace("FOLDER", str(folder))
    assert caret.strip() == "^"
    assert source[caret.index("^") :].startswith(case.at), (source, caret)
    assert not (folder / "log").exists()


@pytest.mark.parametrize("name", WARNINGS)
def test_what_ros_2_runs_nevertheless_gives_a_warning(
    name: str, folder: Path, capfd: pytest.CaptureFixture[str]
):
    case = WARNINGS[name]
    file = written(folder, case)

    code = main(["plan", str(file), *case.words])

    said = [line for line in capfd.readouterr().out.splitlines() if line.startswith("warning: ")]
    assert code == ExitCode.OK
    assert said[0] == f"warning: {file}:{case.line}: {case.message}; hint: {case.hint}"


RIGHT = {
    "a description": "LogInfo(msg=LaunchConfiguration('d').describe()),",
    "a comparison with another substitution": (
        "LogInfo(msg=str(LaunchConfiguration('d') == TextSubstitution(text='x'))),"
    ),
    "an argument that the other file declares": (
        "IncludeLaunchDescription(HERE + '/child.launch.xml', launch_arguments=[('count', '1')]),"
    ),
    "an argument that ROS 2 itself reads": (
        "IncludeLaunchDescription(HERE + '/child.launch.xml',"
        " launch_arguments=[('sigterm_timeout', '1')]),"
    ),
    "an argument that is read without a declaration": (
        "IncludeLaunchDescription(HERE + '/reads.launch.xml', launch_arguments=[('b', '1')]),"
    ),
    "an argument that a function may read": (
        "IncludeLaunchDescription(HERE + '/function.launch.py', launch_arguments=[('r_2', '1')]),"
    ),
    "a program with a space in its name": "ExecuteProcess(cmd=[HERE + '/my program']),",
    "a shell command": "ExecuteProcess(cmd=['ls -la'], shell=True),",
    "a function that has nothing to return": "OpaqueFunction(function=lambda context: None),",
}


@pytest.mark.parametrize("name", RIGHT)
def test_what_is_right_gives_no_warning(name: str, folder: Path, capfd: pytest.CaptureFixture[str]):
    (folder / "my program").touch()
    (folder / "reads.launch.xml").write_text(
        '<launch><arg name="a" default="1"/><log message="$(var b)"/></launch>'
    )
    (folder / "function.launch.py").write_text(
        HEAD + "def read(context):\n"
        "    return [LogInfo(msg=context.launch_configurations[f'r_{n}']) for n in (1, 2)]\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([DeclareLaunchArgument('r_1', default_value='x'),\n"
        "        OpaqueFunction(function=read)])\n"
    )
    file = folder / "case.launch.py"
    body = textwrap.dedent(described(RIGHT[name]))
    file.write_text(f"{HEAD}HERE = os.path.dirname(__file__)\n{body}")

    code = main(["plan", str(file)])

    said = capfd.readouterr()
    assert (code, said.err) == (ExitCode.OK, "")
    assert [line for line in said.out.splitlines() if line.startswith(f"warning: {folder}")] == []
