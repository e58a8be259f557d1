"""Suggestions, counts and filters of control characters."""

from __future__ import annotations

from pathlib import Path

import pytest

from launcher.base import text

VERBS = ["kill", "logs", "restart", "cat", "act", "robot_1", "robot_1", "robot_2"]


@pytest.mark.parametrize(
    ("word", "expected"),
    [
        ("kil", "kill"),
        ("restrat", "restart"),
        ("lgso", "logs"),
        ("bogus", None),
        ("", None),
        ("robot_9", None),
        ("robot_11", "robot_1"),
        ("tca", None),  # as near to cat as to act
        ("robto_1", "robot_1"),
    ],
)
def test_only_a_similar_word_is_suggested(word: str, expected: str | None):
    assert text.suggest(word, iter(VERBS)) == expected


def test_the_question_names_the_word():
    assert text.did_you_mean("kil", VERBS) == "did you mean 'kill'?"
    assert text.did_you_mean("bogus", VERBS) is None


def test_all_of_several_choices_are_named():
    assert text.one_of(["a"]) == "'a'"
    assert text.one_of(["a", "b", "c"]) == "'a', 'b' or 'c'"


def test_a_path_is_shown_without_dots_where_that_is_the_same_file(tmp_path: Path):
    (tmp_path / "sub" / "below").mkdir(parents=True)
    (tmp_path / "link").symlink_to(tmp_path / "sub" / "below")
    assert text.shown_path(f"{tmp_path}/sub/.././a.py") == f"{tmp_path}/a.py"
    assert text.shown_path("./a/../b.py") == "b.py"
    through_link = f"{tmp_path}/link/../a.py"
    assert text.shown_path(through_link) == through_link


@pytest.mark.parametrize(
    ("number", "noun", "expected"),
    [
        (1, "process", "1 process"),
        (0, "process", "0 processes"),
        (2, "node", "2 nodes"),
    ],
)
def test_a_noun_agrees_with_its_number(number: int, noun: str, expected: str):
    assert text.count(number, noun) == expected


def test_what_is_not_printable_is_escaped():
    assert text.escape("a\x1b[2Jb\n\tc\u202e\udc80") == "a\\x1b[2Jb\n\tc\\u202e\\udc80"
    assert text.escape("a\nb", keep="") == "a\\nb"


def test_control_characters_alone_are_escaped():
    assert (
        text.escape_controls("a\x1b[2J\r\x9b\n\tä漢\u3000🤖")
        == "a\\x1b[2J\\x0d\\x9b\n\tä漢\u3000🤖"
    )


def test_colours_survive_where_other_controls_are_dropped():
    assert (
        text.drop_controls("\x1b[1;31mred\x1b[0m\x1b[2J\a\x9b\n\tx")
        == "\x1b[1;31mred\x1b[0m[2J\n\tx"
    )


@pytest.mark.parametrize(
    ("error", "plain", "typed"),
    [
        (ValueError("no number"), "no number", "ValueError: no number"),
        (AssertionError(), "AssertionError", "AssertionError"),
    ],
)
def test_the_text_of_an_exception_is_never_empty(error: Exception, plain: str, typed: str):
    assert (text.error_text(error), text.typed_error(error)) == (plain, typed)


def test_several_names_are_shortened_only_if_there_are_more():
    assert text.several(["a", "b"], most=2) == "a, b"
    assert text.several(["a", "b", "c"], most=2) == "a, b and 1 more"
