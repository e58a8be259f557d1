"""`help`, `--help` and `-V` on the command line."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import launcher
from launcher.cli.dispatch import CONTROL_VERBS, VERBS, main, overview

Said = tuple[str, str, object]  # on stdout, on stderr, exit code


@pytest.fixture
def run(capsys) -> Callable[..., Said]:
    """Runs a command line in this process."""

    def said(*words: str) -> Said:
        code = main(words)
        out, err = capsys.readouterr()
        return out, err, code

    return said


@pytest.mark.parametrize("words", [["help"], ["help", "help"], ["help", "-h"], ["--help"], ["-h"]])
def test_help_alone_is_the_overview(run, words):
    assert run(*words) == (overview() + "\n", "", 0)


@pytest.mark.parametrize("name", [*VERBS, *CONTROL_VERBS])
def test_help_and_a_verb_is_the_help_of_the_verb(run, name):
    out, err, code = run("help", name)
    assert (out, err, code) == run(name, "--help")
    assert out.startswith("usage: ") and code == 0


def test_help_goes_down_to_a_verb_of_a_verb_and_runs_no_program(run):
    assert run("help", "topic", "echo") == run("topic", "echo", "--help")
    assert run("help", "run", "group_gp1", "robot_1") == run("help", "run")


@pytest.mark.parametrize(
    ("name", "hint"),
    [("tpoic", "did you mean 'topic'?"), ("bogus", "python -m launcher help lists the verbs")],
)
def test_help_of_an_unknown_verb_is_an_error(run, name, hint):
    assert run("help", name) == ("", f"error: unknown verb '{name}'\nhint: {hint}\n", 2)


@pytest.mark.parametrize("word", ["-V", "--version"])
def test_the_version_is_printed_alone(run, word):
    assert run(word) == (f"{launcher.__version__}\n", "", 0)


@pytest.mark.parametrize(
    ("line", "same"),
    [
        ("-- --version", "--version"),
        ("-- topic -- list --help", "topic list --help"),
        ("-- no-such-file", "no-such-file"),
        ("plan -- no-such-file", "plan no-such-file"),
        ("no-such-file --", "no-such-file"),
    ],
)
def test_two_dashes_are_accepted_before_every_word(run, line, same):
    assert run(*line.split()) == run(*same.split())
