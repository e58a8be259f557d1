"""Lines that are typed into the console, those that it shows, and their history."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any, cast

import pytest

from launcher.base import verb_table as commands
from launcher.base.errors import UsageError
from launcher.base.program import program
from launcher.control.client import Reply
from launcher.control.console.feed import split
from launcher.control.console.history_file import history_path
from launcher.control.console.prompt import MAX_LINES, open_history
from launcher.control.console.requests import (
    SHELL_VERBS,
    answer,
    follows,
    read_call,
    read_shell_words,
)
from launcher.control.verbs import VERBS


def test_a_line_is_read_as_by_a_shell():
    call = read_call("send robot_1 'hello  world'")
    assert (call.verb.name, call.names, call.options) == (
        "send",
        ("robot_1",),
        {"text": "hello  world"},
    )


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("kil robot_1", "unknown verb 'kil'"),
        ("kill 'robot_1", "the line is not finished: No closing quotation"),
        ("kill", "kill needs the name of a process"),
    ],
)
def test_a_mistake_is_told(line: str, message: str):
    with pytest.raises(UsageError, match=message):
        read_call(line)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("topic list -t", ["topic", "list", "-t"]),
        ("topic pub /a b 'c d'", ["topic", "pub", "/a", "b", "c d"]),
        ("runs", ["runs"]),
        ("help topic", ["help", "topic"]),
        ("ps", None),
        ("help", None),
        ("help ps", None),
        ("attach", None),
    ],
)
def test_verbs_of_shells_run_here(line: str, words: list[str] | None):
    assert read_shell_words(line) == words


PROGRAMS = ("launcher", "python -m launcher", "python3.12 -m launcher", ".venv/bin/launcher")


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_name_of_the_program_is_dropped(name: str):
    call = read_call(f"{name} send robot_1 'hello  world'")
    assert (call.verb.name, call.names) == ("send", ("robot_1",))
    assert call.options == {"text": "hello  world"}
    assert read_shell_words(f"{name} topic pub /a b 'c d'") == ["topic", "pub", "/a", "b", "c d"]
    assert read_shell_words(f"{name} help topic") == ["help", "topic"]
    assert read_shell_words(f"{name} ps") is None
    with pytest.raises(UsageError, match="is a verb for shells") as raised:
        read_call(f"{name} launch 'a b'")
    assert raised.value.hint == f"in another shell: {program()} launch 'a b'"


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_name_of_the_program_alone_is_answered_as_help(name: str):
    assert read_shell_words(name) is None
    call = read_call(name)
    assert (call.verb.name, call.options) == ("help", {})


def test_other_programs_are_none_of_ours():
    for line in ("python -m launchers ps", "python -m", "launchers ps"):
        with pytest.raises(UsageError, match=f"unknown verb '{line.split()[0]}'"):
            read_call(line)


@pytest.mark.parametrize("line", ["attach", "launch system", "agent"])
def test_a_verb_for_shells_is_told_with_its_command(line: str):
    with pytest.raises(UsageError, match="is a verb for shells") as raised:
        read_call(line)
    assert raised.value.hint == f"in another shell: {program()} {line}"


def test_every_verb_of_the_command_line_is_known_in_the_console():
    names = [verb.name for verb in VERBS]
    assert {*commands.VERBS, *commands.CONTROL_VERBS} <= {*names, *SHELL_VERBS}
    assert not set(names) & set(SHELL_VERBS)


class Answering:
    """A run that answers every request with this text."""

    def __init__(self, text: str) -> None:
        self._text = text

    def connect(self) -> Answering:
        return self

    def __enter__(self) -> Answering:
        return self

    def __exit__(self, *error: object) -> None:
        pass

    def ask(self, verb: str, names: list[str], **options: object) -> Reply:
        return Reply(result={}, text=(self._text,))


@pytest.mark.parametrize(("line", "shown"), [("detach", ""), ("quit", "done")])
def test_what_the_run_itself_writes_is_not_answered(line: str, shown: str):
    run = Answering("done")
    text = answer(cast("Any", run), read_call(line), 80, colour=False)
    assert text.strip() == shown


@pytest.mark.parametrize(("word", "verb"), [("exit", "quit"), ("q", "quit"), ("?", "help")])
def test_the_help_names_every_spelling(word: str, verb: str):
    assert read_call(word).verb.name == verb
    text = answer(None, read_call("help all"), 120, colour=False)
    assert re.search(rf"^{re.escape(verb)} .*{re.escape(word)}", text, re.M)
    assert re.search("^clear +clear the screen", text, re.M)


@pytest.mark.parametrize(
    ("line", "hint"),
    [
        ("bogus", "`help all` lists all verbs"),
        ("hepl", "did you mean 'help'?"),
        ("sp", "did you mean 'ps'?"),
        ("retsart robot_1", "did you mean 'restart'?"),
    ],
)
def test_only_what_is_near_is_suggested(line: str, hint: str):
    with pytest.raises(UsageError) as raised:
        read_call(line)
    assert raised.value.hint == hint


def test_top_is_live_and_logs_are_if_asked():
    assert follows(read_call("top"))
    assert follows(read_call("logs -f robot_1"))
    assert not follows(read_call("logs robot_1"))
    assert not follows(read_call("ps"))


# ---- lines


@pytest.mark.parametrize(
    ("data", "lines", "partial"),
    [
        (b"a\nb\n", b"a\nb\n", b""),
        (b"a\nb", b"a\n", b"b"),
        (b"10%\r\x1b[K[p] 20%", b"", b"[p] 20%"),
        (b"x\n10%\r\x1b[K[p] 99%\nnext", b"x\n[p] 99%\n", b"next"),
    ],
)
def test_a_block_is_split_into_whole_lines_and_a_beginning(
    data: bytes, lines: bytes, partial: bytes
):
    assert split(data) == (lines, partial)


# ---- history


def test_the_history_is_bounded_and_for_its_user_alone(tmp_path: Path):
    path = tmp_path / "state" / "ros-launcher" / "history"
    history = open_history(path)
    for number in range(2 * MAX_LINES + 1):
        history.store_string(f"line {number}")
    assert os.stat(path).st_mode & 0o077 == 0
    again = list(open_history(path).load_history_strings())
    assert again[0] == f"line {2 * MAX_LINES}"
    assert len(again) == len(path.read_text().splitlines()) == MAX_LINES


def test_the_history_is_in_the_state_directory():
    assert history_path({"XDG_STATE_HOME": "/s"}) == Path("/s/ros-launcher/history")
    assert history_path({}).parts[-4:] == (".local", "state", "ros-launcher", "history")


@pytest.mark.parametrize(
    ("line", "meant"),
    [
        ("status", "ps"),
        ("list", "ps"),
        ("shutdown", "quit"),
        ("topics", "topic list"),
        ("kil", "kill"),
    ],
)
def test_words_of_other_programs_are_answered_by_what_is_meant(line: str, meant: str):
    with pytest.raises(UsageError, match=f"unknown verb '{line}'") as raised:
        read_call(line)
    assert raised.value.hint == f"did you mean '{meant}'?"
