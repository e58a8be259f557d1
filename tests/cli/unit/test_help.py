"""`help`, `--help` and `-V` on the command line."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import launcher
from launcher.bag.verbs import record
from launcher.base.command_help import explanation
from launcher.base.verb_table import CONTROL_VERBS, INTERNAL, TASK_OF, TASKS, VERBS
from launcher.cli.dispatch import main
from launcher.cli.overview import overview
from launcher.launch.launch_options import RUN_GROUPS
from launcher.packages import distribution
from launcher.run.part import OPTION_GROUPS
from launcher.run.parts import ROWS
from tools.command_reference import commands

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


@pytest.mark.parametrize("words", [["help", "--all"], ["--help", "--all"], ["-h", "--all"]])
def test_help_of_all_has_the_internal_verbs_as_well(run, words):
    assert run(*words) == (overview(is_whole=True) + "\n", "", 0)


def rows_of(text: str) -> dict[str, list[str]]:
    """The first words of the rows below each title."""
    blocks = (block.split("\n") for block in text.split("\n\n"))
    return {title: [row.split()[0] for row in rows if row] for title, *rows in blocks}


@pytest.mark.parametrize("is_whole", [False, True])
def test_the_overview_has_every_verb_once_below_its_task(is_whole):
    found = rows_of(overview(is_whole=is_whole))
    titles = {**TASKS, INTERNAL: INTERNAL} if is_whole else TASKS
    for task, title in titles.items():
        verbs = found.pop(f"{title}:")
        assert sorted(verbs) == sorted(verb for verb, one in TASK_OF.items() if one == task)
    assert f"{INTERNAL}:" not in found


def test_without_words_the_first_steps_are_shown(run):
    out, err, code = run()
    lines = out.splitlines()
    assert (err, code) == ("", 2)
    assert len(lines) <= 12
    assert lines[0].startswith("usage: python -m launcher TARGET ")
    assert lines[-1] == "next: python -m launcher system, then type help"
    assert all(task in out for task in TASKS)


def test_the_first_steps_name_a_launch_file_only_where_there_is_one(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run()[0].splitlines()[-1] == "next: python -m launcher TARGET, then type help"
    (tmp_path / "launch").mkdir()
    (tmp_path / "launch" / "mine.launch.xml").touch()
    assert run()[0].splitlines()[-1] == "next: python -m launcher mine, then type help"


def test_every_option_of_a_run_is_in_one_group_of_the_help(run):
    for row in ROWS:
        assert (row.group in OPTION_GROUPS) == bool(row.options), row.part
    found = rows_of(run("launch", "--help")[0])
    for title, options in RUN_GROUPS:
        assert {one.flags[0].rstrip(",") for one in options} <= {
            word.rstrip(",").partition("[")[0] for word in found[f"{title}:"]
        }


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
def test_the_version_is_printed_with_the_ros_in_use(run, word):
    assert run(word) == (f"{launcher.__version__} ({distribution.title()})\n", "", 0)


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


def test_no_option_is_explained_with_two_defaults():
    for command in commands():
        grouped = (one for _, group in command.groups for one in group)
        for one in (*command.arguments, *command.options, *grouped):
            assert explanation(one).count("(default") <= 1, (command.name, one.spelling)
    explained = {one.spelling: explanation(one) for one in record.COMMAND.options}
    assert explained["--max-cache-size BYTES"].endswith("(default: 100M)")
