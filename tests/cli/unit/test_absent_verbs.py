"""Verbs of ros2cli that this launcher lacks, unless a launch file has that name."""

from __future__ import annotations

import pytest

from launcher.cli import dispatch as cli
from tests.support.verbs import in_process


def test_no_absent_verb_exists():
    assert not cli.ABSENT_VERBS.keys() & {*cli.CONTROL_VERBS, *cli.VERBS}


@pytest.mark.parametrize(
    "words",
    [
        ["security", "list_enclaves"],
        ["component", "list"],
        ["help", "trace"],
    ],
    ids=" ".join,
)
def test_an_absent_verb_is_reported_with_its_replacement(words):
    answer = in_process(*words)
    verb = "trace" if words[0] == "help" else words[0]
    assert (answer.out, answer.code) == ("", 2)
    hint = cli.ABSENT_VERBS[verb] or "PROGRAM --help lists the verbs"
    hint = hint.replace("PROGRAM", "python -m launcher")
    assert answer.err == (f"error: ros2cli's verb '{verb}' does not exist here\nhint: {hint}\n")


@pytest.mark.parametrize("words", [["pick"], ["pick", "--run", "x"], ["help", "pick"]])
def test_a_verb_of_the_console_is_reported_as_such(words):
    answer = in_process(*words)
    assert (answer.out, answer.code) == ("", 2)
    assert answer.err == (
        "error: 'pick' exists only in the console of a running launch\n"
        "hint: python -m launcher ps lists the processes; F2 opens the list in the console\n"
    )


def test_a_launch_file_of_that_name_is_launched(tmp_path, monkeypatch):
    (tmp_path / "launch").mkdir()
    file = tmp_path / "launch" / "component.launch.py"
    file.write_text(
        "from launch import LaunchDescription\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([])\n",
        encoding="utf-8",
    )
    monkeypatch.chdir(tmp_path)
    answer = in_process("component", "--show-args")
    assert (answer.code, "does not exist here" in answer.err) == (0, False), answer
