"""A first word that is no verb, no launch file and no package; words and options of others."""

from __future__ import annotations

from pathlib import Path

import pytest

import launcher
from launcher.packages.distribution import title
from tests.support.verbs import in_process

EMPTY = """\
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument

def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("enable_debug", default_value="false"),
        DeclareLaunchArgument("robot_count", default_value="2"),
        DeclareLaunchArgument("map-file", default_value=""),
    ])
"""
PROGRAM = "python -m launcher"


@pytest.fixture(autouse=True)
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with `launch/mine.launch.py`, which is the working directory."""
    (tmp_path / "launch").mkdir()
    (tmp_path / "launch" / "mine.launch.py").write_text(EMPTY, encoding="utf-8")
    (tmp_path / "package.xml").write_text("<package/>", encoding="utf-8")  # no folder above it
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    return tmp_path


def refused(*words: str) -> tuple[str, str]:
    """(the message, the hint) of a command line with a mistake."""
    answer = in_process(*words)
    assert (answer.out, answer.code) == ("", 2), answer
    message, _, hint = answer.err.partition("\nhint: ")
    return message.removeprefix("error: ").rstrip("\n"), hint.rstrip("\n")


@pytest.mark.parametrize(
    ("line", "meant"),
    [
        ("status", "ps"),
        ("list", "ps"),
        ("state robot_1", "ps"),
        ("down", "quit"),
        ("up mine", "mine"),
        ("up", "TARGET"),
        ("up --wait", "TARGET"),
        ("docker up", "export compose TARGET"),
        ("systemd mine", "export systemd mine"),
        ("log robot_1", "logs"),
        ("topics", "topic list"),
        ("ros2 topic list", "topic list"),
        ("list nodes", "node list"),
        ("stauts", "ps"),
        ("sttus --run x", "ps"),
        ("tpoic list", "topic"),
        ("plna mine", "plan"),
        ("mien", "mine"),
        ("status --help", "ps"),
        ("tpoic --help", "topic"),
        ("levle WARN --jsn", "level"),
        ("version now", "--version"),
    ],
)
def test_an_unknown_verb_is_answered_by_what_is_meant(line: str, meant: str):
    message, hint = refused(*line.split())
    assert message.startswith(f"unknown verb '{line.split()[0]}', and there is no launch file ")
    assert hint.splitlines()[0] == f"did you mean `{PROGRAM} {meant}`?"


def test_the_hint_says_what_the_verb_does_that_is_meant():
    assert refused("down")[1].splitlines()[1:] == ["  quit      stop everything and end the run"]


def test_near_verbs_and_near_launch_files_are_both_suggested(project: Path):
    (project / "launch" / "stopp.launch.xml").write_text("<launch/>", encoding="utf-8")
    assert refused("stoppp")[1] == f"did you mean `{PROGRAM} stop` or `{PROGRAM} stopp`?"


def test_several_meanings_are_all_named():
    expected = f"did you mean `{PROGRAM} plan mine` or `{PROGRAM} doctor`?"
    assert refused("check", "mine")[1] == expected


def test_a_word_near_nothing_is_answered_by_what_there_is():
    message, hint = refused("zzzz")
    assert message == "unknown verb 'zzzz', and there is no launch file of this name"
    assert hint.startswith("launch files: ")
    assert "mine" in hint and hint.endswith(f"; {PROGRAM} --help lists the verbs")
    assert "launch file or package" in refused("zzzz", "zzzz")[0]


def test_a_launch_file_may_have_the_name_of_a_verb_of_others(project: Path):
    (project / "launch" / "status.launch.py").write_text(EMPTY, encoding="utf-8")
    assert "'enable_debug'" in in_process("status", "--show-args").out


def test_a_launch_file_beside_is_not_called_a_verb(project: Path):
    (project / "here.launch.py").write_text(EMPTY, encoding="utf-8")
    assert refused("here") == ("launch file 'here' not found", "did you mean 'here.launch.py'?")


def test_a_folder_does_not_hide_what_a_word_means(project: Path):
    (project / "log").mkdir()
    (project / "stuff").mkdir()
    assert refused("log", "robot_1")[1].startswith(f"did you mean `{PROGRAM} logs`?")
    assert refused("stuff")[0] == "'stuff' is a directory"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("./status", "launch file 'status' not found"),
        ("status.launch.py", "launch file 'status.launch.py' not found"),
        ("nav status.launch.py", "package 'nav' not found"),
        ("launch status", "launch file 'status' not found"),
        ("mine --bogus", "unknown option '--bogus'"),
        ("--timeout 5 zzzz", "launch file 'zzzz' not found"),
        ("x:=1", "the launch file is missing"),
    ],
)
def test_files_packages_and_options_are_not_called_verbs(line: str, message: str):
    assert refused(*line.split())[0] == message


def test_a_package_alone_is_answered_by_its_launch_files():
    message, hint = refused("group_gp1")
    assert message == "'group_gp1' is a package, and no launch file has this name"
    assert hint.startswith("launch files of the package: system.launch.py, ")
    assert hint.endswith(f"for example: {PROGRAM} group_gp1 system.launch.py")


def test_an_executable_is_answered_by_run():
    assert refused("robot_1")[1] == f"did you mean `{PROGRAM} run group_gp1 robot_1`?"


@pytest.mark.parametrize(
    ("line", "hint"),
    [
        ("run robot_1", f"did you mean `{PROGRAM} run group_gp1 robot_1`?"),
        ("run mine", f"did you mean `{PROGRAM} mine`?"),
        ("run zzzz", "searched: "),
    ],
)
def test_one_word_behind_run(line: str, hint: str):
    message, given = refused(*line.split())
    assert message == f"package '{line.split()[1]}' not found"
    assert given.startswith(hint)


def test_version_is_a_verb_where_no_launch_file_is(project: Path):
    answer = in_process("version")
    assert (answer.out, answer.err, answer.code) == (f"{launcher.__version__} ({title()})\n", "", 0)
    (project / "launch" / "version.launch.py").write_text("1 / 0", encoding="utf-8")
    assert "ZeroDivisionError" in in_process("version").err


def test_help_of_a_question_is_no_action():
    assert refused("help", "status") == ("unknown verb 'status'", "did you mean 'ps'?")


@pytest.mark.parametrize(
    ("line", "meant"),
    [
        ("mine --enable-debug", "enable_debug:=true"),
        ("mine --enable_debug", "enable_debug:=true"),
        ("mine --enable-debug=yes", "enable_debug:=yes"),
        ("mine --no-enable-debug", "enable_debug:=false"),
        ("--enable-debug mine", "enable_debug:=true"),
        ("mine --enable-debg", "enable_debug:=true"),
        ("mine --robot-count 5", "robot_count:=5"),
        ("mine --robot-count", "robot_count:=VALUE"),
        ("mine --map-file=a.yaml", "map-file:=a.yaml"),
        ("plan mine --enable-debug", "enable_debug:=true"),
        ("args mine --enable-debug", "enable_debug:=true"),
        ("smoke mine --enable-debug", "enable_debug:=true"),
        ("export systemd mine --enable-debug", "enable_debug:=true"),
    ],
)
def test_an_option_that_is_an_argument_of_the_launch_file(line: str, meant: str):
    assert refused(*line.split())[1] == f"did you mean {meant}?"


@pytest.mark.parametrize(
    ("line", "hint"),
    [
        ("mine --tiemout 5", "did you mean '--timeout'?"),
        ("mine --enable-colours", f"usage: {PROGRAM} launch TARGET [name:=value ...] [options]"),
        ("mine --dry-run", f"`{PROGRAM} plan TARGET` shows what would be started"),
    ],
)
def test_other_options_are_not_taken_for_an_argument(line: str, hint: str):
    assert refused(*line.split())[1] == hint


@pytest.mark.parametrize("line", ["mine --colours 5", "mine --colours=5 --lenient"])
def test_an_option_with_a_value_that_nothing_has_is_shown_as_an_argument(line: str):
    declared = "this launch file declares enable_debug, robot_count, map-file"
    assert refused(*line.split())[1] == f"launch arguments are written colours:=5; {declared}"


def test_a_launch_file_behind_an_option_is_not_its_value():
    assert refused("--colours", "mine")[1].startswith("usage: ")


@pytest.mark.parametrize(
    ("line", "hint"),
    [
        ("mine private", "did you mean --private?"),
        ("mine robot_count:=5 private", "did you mean --private?"),
        ("mine help", "did you mean --help?"),
        ("mine debug", f"did you mean --debug, or `{PROGRAM} debug`?"),
        ("plan mine lenient", "did you mean --lenient?"),
    ],
)
def test_an_option_without_its_dashes(line: str, hint: str):
    assert refused(*line.split())[1] == hint


def test_a_launch_file_with_a_mistake_does_not_hide_that_of_the_option(project: Path):
    (project / "launch" / "broken.launch.py").write_text("import sys; sys.exit(3)", "utf-8")
    assert refused("broken", "--enable-debug")[0] == "unknown option '--enable-debug'"


def test_a_name_and_its_value_in_two_words():
    assert refused("mine", "robot_count", "5")[1] == "did you mean robot_count:=5?"


@pytest.mark.parametrize(
    ("line", "meant"),
    [("mine ps", "ps"), ("mine plan", "plan mine"), ("mine topic", "topic")],
)
def test_a_verb_behind_a_launch_file(line: str, meant: str):
    assert refused(*line.split())[1] == f"did you mean `{PROGRAM} {meant}`?"


def test_to_start_a_launch_file_is_to_launch_it():
    answer = in_process("start", "mine")
    assert (answer.err, answer.code) == (
        f"error: no active run\nhint: did you mean `{PROGRAM} mine`?\n",
        1,
    )


def test_a_verb_that_needs_names_says_what_stands_for_all():
    hint = "usage: stop NAME ...; '*' stands for all processes"
    assert refused("stop") == ("stop needs the name of a process", hint)
    assert refused("restart", "--all")[1] == "'*' stands for all processes"


@pytest.mark.parametrize(
    ("line", "meant"), [("logs --tail 5", "--lines"), ("top --interval 1", "--period")]
)
def test_an_option_by_another_name(line: str, meant: str):
    assert refused(*line.split())[1] == f"did you mean '{meant}'?"


def test_to_test_a_launch_file_is_smoke(project: Path):
    package = project / "src" / "one"
    package.mkdir(parents=True)
    (package / "package.xml").write_text(
        "<package format='3'><name>one</name><version>0.0.1</version><description>x</description>"
        "<maintainer email='a@example.com'>a</maintainer><license>MIT</license></package>",
        encoding="utf-8",
    )
    (project / "package.xml").unlink()
    message, hint = refused("test", "mine")
    assert message == f"no package 'mine' in {project}/src"
    assert hint == f"to test a launch file: {PROGRAM} smoke mine"


@pytest.mark.parametrize("option", ["-d", "--debug"])
@pytest.mark.parametrize(("word", "meant"), [("up", "TARGET"), ("bogus", "--help lists the verbs")])
def test_the_option_for_tracebacks_does_not_hide_what_an_unknown_verb_means(word, meant, option):
    message, hint = refused(word, option)
    assert message.startswith(f"unknown verb '{word}'")
    assert meant in hint


@pytest.mark.parametrize(
    ("line", "command"),
    [
        ("run talker.py", "python3 talker.py"),
        ("run talker.py 5", "python3 talker.py"),
        ("run ./talker.py", "python3 ./talker.py"),
        ("run ../{folder}/talker.py", "python3 ../{folder}/talker.py"),
        ("run talker", "./talker"),
        ("run launch/mine.launch.py", f"{PROGRAM} launch/mine.launch.py"),
    ],
)
def test_a_file_in_the_place_of_a_package_is_shown_how_to_run(project, line: str, command: str):
    for name in ("talker.py", "talker"):
        (project / name).touch()
    _, hint = refused(*line.format(folder=project.name).split())
    assert f"`{command.format(folder=project.name)}`" in hint
