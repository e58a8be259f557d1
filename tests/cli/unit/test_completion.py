"""The candidates of the completion, by the tables of options, and their quoting."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from launcher.base.verb_table import CONTROL_VERBS, VERBS
from launcher.cli.completion import name_sources
from launcher.cli.completion.candidates import split
from launcher.cli.dispatch import main

LAUNCH_FILE = """
import os
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument

def generate_launch_description():
    os.write(1, b'noise')
    return LaunchDescription([
        DeclareLaunchArgument('mode', choices=['fast', 'fair', 'slow'], description='how'),
        DeclareLaunchArgument('debug', default_value='false'),
        DeclareLaunchArgument('map_file', default_value='x'),
    ])
"""
Complete = Callable[..., list[str]]


@pytest.fixture
def complete(capfd, tmp_path: Path, monkeypatch) -> Complete:
    """The completions of a command line in a project with a launch file."""
    project = tmp_path / "project"  # not beside those of other tests, which look there
    for folder in ("launch", "my maps"):
        (project / folder).mkdir(parents=True)
    (project / "package.xml").write_text("<package><name>demo_here</name></package>")
    for file in ("launch/demo.launch.py", "my maps/a b.launch.py"):
        (project / file).write_text(LAUNCH_FILE)
    monkeypatch.chdir(project)

    def completions(line: str, shell: str = "bash", breaks: str = " \t\n\"'><=;|&(:") -> list[str]:
        words = [line, breaks] if shell == "bash" else line.split(" ")[1:]
        assert main(["completion", shell, *words]) == 0
        return capfd.readouterr().out.splitlines()

    return completions


def test_a_first_word_is_a_verb_a_launch_file_or_a_path(complete: Complete):
    found = complete("launcher ")
    assert {f"{verb} " for verb in (*VERBS, *CONTROL_VERBS)} <= set(found)
    assert {"demo ", "launch/", r"my\ maps/"} <= set(found)
    assert complete("launcher pl") == ["plan "]
    assert complete("launcher -- pl") == ["plan "]
    assert complete("launcher --v") == ["--version "]
    assert "rclpy " in complete("launcher rcl")


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("launcher topic ec", ["echo "]),
        ("launcher -d 83 top", ["topic "]),
        ("launcher -d 83 topic ec", ["echo "]),
        ("launcher topic --spin-time 2 ec", ["echo "]),
        ("launcher --json topic echo --on", ["--once "]),
        ("launcher param del", ["delete "]),
        ("launcher multicast re", ["receive "]),
        ("launcher pkg exec", ["executables "]),
        ("launcher pkg prefix std_ms", ["std_msgs "]),
        ("launcher wtf --fi", ["--fix "]),
        ("launcher plan --le", ["--lenient "]),
        ("launcher launch demo --time", ["--timeout "]),
        ("launcher plan -- --le", []),
        ("launcher topic echo --qos-reliability re", ["reliable "]),
        ("launcher topic echo --qos-reliability=re", ["reliable "]),
        ("launcher kill --signal SIGTE", ["SIGTERM "]),
        ("launcher level W", ["WARN "]),
        ("launcher loglevel robot_1 W", ["WARN "]),
        ("launcher loglevel robot_1 rcl A", []),
        ("launcher inject robot_1 s", ["slow "]),
        ("launcher inject robot_1 slow s", []),
        ("launcher completion f", ["fish "]),
        ("launcher run group_gp1 moni", ["monitor "]),
        ("launcher no_such_package no", []),
        ("launcher launch demo --timeout ", []),
        ("launcher demo --time", ["--timeout "]),
    ],
)
def test_words_follow_the_tables_of_options(complete: Complete, line: str, expected: list[str]):
    assert complete(line) == expected


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("launcher launch demo mo", ["mode:="]),
        ("launcher launch demo mode:=fast ", ["debug:=", "map_file:="]),
        ("launcher launch demo mode:=fa", ["fast ", "fair "]),
        ("launcher launch demo debug:=", ["true ", "false "]),
        ("launcher demo enable_d", ["enable_debug:="]),  # of the fleet
        ("launcher plan demo map_file:=launch/d", ["launch/demo.launch.py "]),
        ("launcher plan demo map_file:=./my", [r"./my\ maps/"]),
        (r"launcher my\ ma", [r"my\ maps/"]),
        (r"launcher my\ maps/", [r"my\ maps/a\ b.launch.py "]),
        ("launcher 'my ma", ["my maps/"]),
        ('launcher "my maps/a', ["my maps/a b.launch.py"]),
        (r"launcher my\ maps/a\ b.launch.py mode:=s", ["slow "]),
        ("launcher 'my maps/a b.launch.py' mode:=s", ["slow "]),
    ],
)
def test_launch_files_and_their_arguments(complete: Complete, line: str, expected: list[str]):
    assert complete(line) == expected


def test_without_breaks_the_whole_word_is_replaced(complete: Complete):
    assert complete("launcher launch demo mode:=s", breaks=" ") == ["mode:=slow "]


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_get_whole_words_with_their_texts(complete: Complete, shell: str):
    assert complete("launcher launch demo mo", shell) == [
        "mode:=\thow. Valid choices are: ['fast', 'fair', 'slow']"
    ]
    assert complete("launcher launch demo mode:=s", shell) == ["mode:=slow"]
    assert complete("launcher pl", shell) == [f"plan\t{VERBS['plan']}"]


def test_processes_are_those_of_the_run_that_is_named(complete: Complete, monkeypatch):
    asked: list[str | None] = []

    def processes(run: str | None) -> list[tuple[str, str]]:
        asked.append(run)
        return [("robot_1-3", "fleet")]

    monkeypatch.setattr(name_sources, "processes", processes)
    for line in ("kill ro", "logs -f ro", "ps --run 7 ro", "stop --run=8 -- ro"):
        assert complete(f"launcher {line}") == ["robot_1-3 "]
    assert asked == [None, None, "7", "8"]


def test_names_of_the_graph_are_what_the_verbs_list(complete: Complete, monkeypatch):
    monkeypatch.setattr(name_sources, "_lines", lambda *words: [("/" + "/".join(words), "")])
    assert complete("launcher topic echo ") == ["/topic/list "]
    assert complete("launcher node info ") == ["/node/list "]
    assert complete("launcher param get /a ") == ["/param/list//a "]
    assert complete("launcher action info ") == ["/action/list "]
    assert complete("launcher action send_goal /a ") == ["/action/type//a "]
    assert complete("launcher service echo ") == ["/service/list "]
    assert complete("launcher service call /a ") == ["/service/type//a "]
    assert complete("launcher lifecycle get ") == ["/lifecycle/nodes "]
    assert complete("launcher topic pub /a ") == ["/interface/list "]


def test_types_are_those_of_the_kind_and_transitions_those_of_the_node(
    complete: Complete, monkeypatch
):
    lists = {
        ("action", "type", "/new"): [],
        ("interface", "list", "--only-actions"): ["Actions:", "pkg/action/Fold"],
        ("lifecycle", "list", "/pump"): [
            "- configure [1]",
            "Start: unconfigured",
            "- shutdown [5]",
        ],
    }
    monkeypatch.setattr(name_sources, "_lines", lambda *words: [(one, "") for one in lists[words]])
    assert complete("launcher action send_goal /new ") == ["pkg/action/Fold "]
    assert complete("launcher action find ") == ["pkg/action/Fold "]
    assert complete("launcher lifecycle set /pump ") == ["configure ", "shutdown "]
    assert complete("launcher lifecycle set /pump s") == ["shutdown "]


def test_words_are_split_as_by_a_shell():
    assert split(r"""a 'b c' "d\"e" f\ g""") == (["a", "b c", 'd"e', "f g"], r"f\ g", "")
    assert split("a 'b ") == (["a", "b "], "'b ", "'")
    assert split("a ") == (["a", ""], "", "")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_names_a_program_that_exists(shell: str, capsys):
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    program = next(word for word in script.split() if word.endswith(("python", "python3")))
    assert os.access(program, os.X_OK)
