"""--workspace in front of a verb or behind it, and the words that are left."""

from __future__ import annotations

import os
import re

import pytest

from launcher.base.errors import UsageError
from launcher.base.option import WORKSPACE
from launcher.cli.completion.candidates import candidates
from launcher.cli.workspace_option import choose_workspace
from launcher.packages.workspace import VARIABLE

FLAG = WORKSPACE.flags[0]


@pytest.fixture(autouse=True)
def unset(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "before")


@pytest.mark.parametrize(
    ("words", "left"),
    [
        ("--workspace /ws topic list", "topic list"),
        ("--workspace=/ws topic list", "topic list"),
        ("topic --workspace /ws list", "topic list"),
        ("topic list --workspace /ws -t", "topic list -t"),
        ("topic -d 83 --workspace /ws list -t", "topic list -d 83 -t"),
        ("topic echo /a --once --workspace=/ws", "topic echo /a --once"),
        (
            "my_pkg a.launch.py x:=1 --workspace /ws --timeout 3",
            "my_pkg a.launch.py x:=1 --timeout 3",
        ),
        ("--workspace /ws --help", "--help"),
        ("--workspace /first ps --workspace /ws", "ps"),
        ("run --workspace /ws pkg exe --workspace /mine", "run pkg exe --workspace /mine"),
    ],
)
def test_the_option_is_taken_out(words: str, left: str):
    assert choose_workspace(words.split()) == left.split()
    assert os.environ[VARIABLE] == "/ws"


@pytest.mark.parametrize(
    "words",
    [
        "run pkg exe --workspace /mine",  # of the program
        "topic list -- --workspace /mine",  # no option
        "topic list --workspace",  # wrong, as its parser will say
        "topic lst --workspace /ws",
        "topic list --wrong --workspace /ws",
        "topic list --help --workspace /ws",
    ],
)
def test_other_words_are_left(words: str):
    assert choose_workspace(words.split()) == words.split()
    assert os.environ[VARIABLE] == "before"


def test_an_empty_folder_is_no_workspace():
    assert choose_workspace([FLAG, "", "ps"]) == ["ps"]
    assert os.environ[VARIABLE] == ""


def test_a_relative_folder_is_that_of_here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    choose_workspace([f"{FLAG}=ws", "ps"])
    assert os.environ[VARIABLE] == f"{tmp_path}/ws"


def test_a_value_is_needed():
    with pytest.raises(UsageError, match="--workspace needs a value: DIR"):
        choose_workspace([FLAG])


@pytest.mark.parametrize(
    ("words", "message", "hint"),
    [
        ("--workspace build", "needs a folder, and 'build' is taken for it", "DIR build"),
        ("--workspace topic list", "needs a folder, and 'topic' is taken", "DIR topic list"),
        ("--workspace=ps", "needs a folder, and 'ps' is taken for it", "DIR ps"),
        ("--workspace /ws", "target or verb is missing behind --workspace /ws", "/ws TARGET|VERB"),
    ],
)
def test_a_missing_folder_or_verb_is_told(words, message, hint):
    with pytest.raises(UsageError, match=re.escape(message)) as caught:
        choose_workspace(words.split())
    assert f"launcher --workspace {hint}" in str(caught.value.hint)


def test_a_folder_may_be_called_like_a_verb(tmp_path, monkeypatch):
    (tmp_path / "build").mkdir()
    monkeypatch.chdir(tmp_path)
    assert choose_workspace([FLAG, "build", "ps"]) == ["ps"]


def test_its_folders_are_completed(tmp_path, monkeypatch):
    (tmp_path / "my_ws").mkdir()
    monkeypatch.chdir(tmp_path)
    for before in ([FLAG], ["topic", "list", FLAG]):
        assert [*candidates([*before, "my"])] == [("my_ws/", "")]
