"""What words of other programs mean here, and what misspelt words are taken for."""

from __future__ import annotations

import pytest

from launcher.base.synonyms import SYNONYMS, meant_below, meant_lines, meant_option, meant_verb
from launcher.base.verb_table import (
    ABSENT_VERBS,
    ALIASES,
    CONSOLE_VERBS,
    CONTROL,
    CONTROL_VERBS,
    TASK_OF,
    VERBS,
)
from launcher.export.verbs.export import ENGINES
from launcher.launch.verbs.launch import COMMAND as LAUNCH
from launcher.smoke.expect.steps import CHAOS_EXAMPLE
from tools.command_reference import commands

ALL = (*VERBS, *CONTROL_VERBS)
ACTIONS = {*(verb for verb, task in TASK_OF.items() if task == CONTROL), "detach", "launch"}
QUESTIONS = ("status", "state", "list", "ls", "stat", "statu", "satus", "stauts", "lsit", "shwo")
# Verbs of verbs that only show something.
LOOKING = {"list", "info", "get", "describe", "check", "packages", "type", "find", "echo", "nodes"}


def test_no_word_of_another_program_is_a_verb():
    assert not {*SYNONYMS} & {*ALL, *ABSENT_VERBS, *ALIASES, *CONSOLE_VERBS}


def test_every_meaning_is_a_command():
    known = {command.name for command in commands()}
    known |= {f"export {engine}" for engine in ENGINES}
    for line in {line for lines in SYNONYMS.values() for line in lines}:
        words = [word for word in line.split() if word.islower() and word[0] != "-"]
        assert not words or " ".join(words) in known, line


@pytest.mark.parametrize(
    ("word", "lines"),
    [
        ("status", ("ps",)),
        ("stauts", ("ps",)),
        ("list", ("ps",)),
        ("down", ("quit",)),
        ("check", ("plan TARGET", "doctor")),
        ("ros2", ("...",)),
        ("plna", ("plan",)),  # as near to `play`
        ("strat", ("start",)),
        ("lunch", ("launch",)),
        ("docter", ("doctor",)),  # as near to `docker`
        ("statt", ()),  # as near to `state` as to `start`
        ("launce", ("launch",)),
        ("tpoic", ("topic",)),
        ("bogus", ()),
        ("", ()),
    ],
)
def test_a_word_means_a_command_line(word: str, lines: tuple[str, ...]):
    assert meant_lines(word, ALL) == lines


@pytest.mark.parametrize("word", QUESTIONS)
def test_a_question_is_not_taken_for_an_action(word: str):
    taken = {line.split()[0] for line in meant_lines(word, ALL)}
    assert not taken & (ACTIONS - {"show"})
    named = CHAOS_EXAMPLE.split()[:1]  # a table of actions
    assert meant_verb(word, [*named, "start", "stop", "restart", "send", "set"]) is None
    for command in commands():
        names = [one.name.rpartition(" ")[2] for one in command.commands]
        hint = meant_below(word, names)
        assert hint is None or hint.split("'")[1] in {*LOOKING, word, "status", "show"}, (
            command.name
        )


def test_a_console_without_that_verb_does_not_suggest_it():
    assert meant_verb("topics", ["ps", "topic"]) == "did you mean 'topic list'?"
    assert meant_verb("topics", ["ps"]) is None
    assert meant_verb("up", ["ps"]) is None


@pytest.mark.parametrize(
    ("word", "names", "meant"),
    [
        ("ls", ["list", "info"], "list"),
        ("lits", ["list", "info"], "list"),
        ("show", ["list", "info"], "info"),
        ("status", ["check", "sync"], "check"),
        ("status", ["status", "start"], "status"),
        ("new", ["create", "list"], "create"),
        ("bogus", ["list"], None),
    ],
)
def test_a_verb_of_a_verb_may_have_another_name(word: str, names: list[str], meant: str | None):
    assert meant_below(word, names) == (meant and f"did you mean '{meant}'?")


def flags_of_launch() -> list[str]:
    return [flag for option in LAUNCH.all_options for flag in option.flags]


@pytest.mark.parametrize(
    ("flag", "near"),
    [
        ("--tiemout", "--timeout"),
        ("--time", "--timeout"),
        ("--log_level", "--log-level"),
        ("--no-log", "--no-log-files"),
        ("--nocontrol", "--no-control"),
        ("-watch", "--watch"),
        ("--enable-debug", None),  # another word more
        ("--no-watch", None),  # the opposite
        ("--console", None),
        ("--no-web", None),
        ("--list", None),  # `--limit` is about something else
        ("--status", None),
        ("--warn", None),
        ("-x", None),
    ],
)
def test_an_option_is_suggested_only_for_its_misspelling(flag: str, near: str | None):
    assert meant_option(flag, flags_of_launch()) == (near and f"did you mean '{near}'?")


@pytest.mark.parametrize(
    ("flag", "text"),
    [
        ("--dry-run", "`python -m launcher plan TARGET` shows what would be started"),
        ("--verbose", "--log-level '*=debug' makes nodes log more"),
        ("-v", "--log-level '*=debug' makes nodes log more"),
        ("--quiet", "--log-level '*=warn' makes nodes log less"),
        ("--no-color", "NO_COLOR=1 in front of the command"),
        ("--color", "FORCE_COLOR=1 in front of the command"),
        ("--version", "`python -m launcher --version` prints the version"),
        ("--json", "plan TARGET --json"),
        ("--background", "--no-console &"),
    ],
)
def test_options_of_other_programs_are_answered_by_a_launch(flag: str, text: str):
    assert text in (meant_option(flag, flags_of_launch(), LAUNCH.elsewhere) or "")


def test_an_answer_names_options_that_exist():
    flags = {flag for command in commands() for one in command.all_options for flag in one.flags}
    for given, text in LAUNCH.elsewhere:
        assert not {*given} & {*flags_of_launch()}
        named = {
            word.strip("`';:,?") for word in text.split() if word.lstrip("`'").startswith("--")
        }
        assert named - flags - {"--args", "--ros-args"} == set()


@pytest.mark.parametrize("flag", ["--no-color", "--quiet", "--dry-run", "--verbose", "--status"])
def test_no_command_takes_an_option_of_another_program_for_one_of_its_own(flag: str):
    for command in commands():
        flags = [one for option in command.all_options for one in option.flags]
        if flag in flags or any(one.startswith(flag) for one in flags):
            continue
        assert not (meant_option(flag, flags) or "").startswith("did you mean"), command.name
