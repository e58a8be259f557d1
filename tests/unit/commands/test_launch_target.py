"""Splitting of `name:=value` arguments of a launch command line."""

import pytest

from launcher.commands.launch.target import split_words
from launcher.errors import UsageError


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
