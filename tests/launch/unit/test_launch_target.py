"""The target and the `name:=value` arguments of a launch command line."""

import pytest

from launcher.base.errors import LauncherError, UsageError
from launcher.launch.target import LaunchRequest, split_words
from launcher.launch.verbs.launch import COMMAND
from tests.support.repository import REPOSITORY


@pytest.mark.parametrize(
    ("words", "targets", "arguments"),
    [
        (["system"], ["system"], []),
        (["pkg", "a.launch.py"], ["pkg", "a.launch.py"], []),
        (["system", "a:=1", "a:=2"], ["system"], [("a", "1"), ("a", "2")]),
        (["system", "a:=b:=c"], ["system"], [("a", "b:=c")]),
        (["system", "a:= b "], ["system"], [("a", " b ")]),
    ],
)
def test_words_are_split_as_ros2_launch_splits_them(words, targets, arguments):
    assert split_words(words) == (targets, arguments)


@pytest.mark.parametrize(
    ("word", "hint"),
    [("a:=", "a value cannot be empty"), (":=1", "the name is missing"), (":=", "the name is")],
)
def test_half_an_argument_is_refused(word, hint):
    with pytest.raises(UsageError, match="malformed launch argument") as caught:
        split_words(["system", word])
    assert caught.value.hint.startswith(hint)


@pytest.mark.parametrize("word", ["debug=true", "debug:true"])
def test_a_wrong_separator_is_refused_with_the_right_one(word):
    with pytest.raises(UsageError) as caught:
        split_words(["system", "a:=1", word])
    assert caught.value.hint == "did you mean debug:=true?"


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (
            ["system", "robot_2"],
            "system.launch.py starts robot_2 with the others; `python -m launcher run group_gp1 "
            "robot_2` runs it alone, `python -m launcher restart robot_2` restarts it in a running "
            "launch",
        ),
        (["system", "robt_2"], "did you mean the node 'robot_2' of system.launch.py?"),
        (["system", "start_robot_2"], "did you mean start_robot_2:=VALUE?"),
        (["system", "enable_debgu"], "did you mean enable_debug:=VALUE?"),
        (
            ["system", "warehouse"],
            "arguments of system.launch.py: enable_debug, start_robot_2, enable_qos_probe",
        ),
        (["sistem", "robot_2"], "did you mean the launch file 'system'?"),
        (["group_gp", "system.launch.py"], "did you mean 'group_gp1'?"),
        (["robot_2"], "did you mean `python -m launcher run group_gp1 robot_2`?"),
    ],
)
def test_words_that_name_no_launch_file_are_explained(monkeypatch, words, hint):
    monkeypatch.chdir(REPOSITORY)
    with pytest.raises(LauncherError) as caught:
        LaunchRequest.of(COMMAND.parse(words))
    assert caught.value.hint == hint
