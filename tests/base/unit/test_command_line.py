"""The grammar of command lines: what every command accepts, and how mistakes are reported."""

from __future__ import annotations

import pytest

from launcher.base.command_help import help_text
from launcher.base.command_line import Command, HelpRequested
from launcher.base.errors import UsageError
from launcher.base.option import count, option, seconds

NAME = option("NAME")
MORE = option("[MORE ...]")
FLAG = option("-f, --flag", "a flag")
LINES = option("-n, --lines N", "a number", count, 100)
TAG = option("--tag TAG", name="tags", repeat="all", default=())
ONCE = option("--once FILE", repeat="once")
COLOUR = option("--colour WHEN", choices=("always", "never"))
MAYBE = option("--maybe[=WORD]")
CLOCK = option("--clock [HZ]", "", count, value=40)
OPTIONS = (FLAG, LINES, TAG, ONCE, COLOUR, MAYBE, CLOCK)
PLAIN = Command("plain", "do it", (NAME, MORE), OPTIONS)
SHORT = Command("short", "do it", (NAME, MORE), OPTIONS, abbreviations=True)
TEXT = Command("text", "do it", (NAME, option("TEXT", count="text")), OPTIONS)
RAW = Command("raw", "do it", (NAME, option("ARG", name="text", count="...")), OPTIONS)

VERBS = Command("all", "do it", commands=(Command("all list", "list"), Command("all show", "show")))


@pytest.mark.parametrize(
    ("command", "line", "values"),
    [
        (PLAIN, "a", {"name": "a", "more": [], "flag": False, "lines": 100, "tags": ()}),
        (PLAIN, "--flag a -n 3 b", {"name": "a", "more": ["b"], "flag": True, "lines": 3}),
        (PLAIN, "a -n=3 --lines=4", {"lines": 4}),
        (PLAIN, "a --tag x --tag=y", {"tags": ("x", "y")}),
        (PLAIN, "a --maybe b", {"maybe": "", "more": ["b"]}),
        (PLAIN, "a --maybe=b", {"maybe": "b"}),
        (PLAIN, "a --clock b", {"clock": 40, "more": ["b"]}),
        (PLAIN, "a --clock 100 b", {"clock": 100, "more": ["b"]}),
        (PLAIN, "a --clock", {"clock": 40}),
        (PLAIN, "a --clock=7 -f", {"clock": 7, "flag": True}),
        (PLAIN, "- -- -f --flag", {"name": "-", "more": ["-f", "--flag"], "flag": False}),
        (SHORT, "a --fl --line=2", {"flag": True, "lines": 2}),
        (SHORT, "a -fn5", {"flag": True, "lines": 5}),
        (SHORT, "a -5 -.5", {"more": ["-5", "-.5"]}),
        (SHORT, "a -1e3 -2. -1E-9", {"more": ["-1e3", "-2.", "-1E-9"]}),
        (SHORT, "a -.inf -.INF -1e999", {"more": ["-.inf", "-.INF", "-1e999"]}),
        (TEXT, "a -x --flag b -- --tag", {"text": ["-x", "b", "--tag"], "flag": True}),
        (RAW, "--flag a -x --flag -- b", {"text": ["-x", "--flag", "--", "b"], "flag": True}),
        (RAW, "a -- --flag", {"text": ["--flag"], "flag": False}),
    ],
)
def test_what_words_mean(command, line, values):
    found = vars(command.parse(line.split()))
    assert {name: found[name] for name in values} == values


@pytest.mark.parametrize(
    ("command", "line", "message", "hint"),
    [
        (PLAIN, "", "NAME is missing", "usage: python -m launcher plain NAME [MORE ...] [options]"),
        (PLAIN, "a --flga", "unknown option '--flga'", "did you mean '--flag'?"),
        (PLAIN, "a --bogus", "unknown option '--bogus'", "usage: python -m launcher plain"),
        (PLAIN, "a -fn5", "unknown option '-fn5'", "an argument that begins with '-' goes behind"),
        (PLAIN, "a -n5", "unknown option '-n5'", "write -n 5; usage: "),
        (PLAIN, "a --fla", "unknown option '--fla'", "did you mean '--flag'?"),
        (PLAIN, "a --flag=1", "--flag takes no value", ""),
        (PLAIN, "a -n", "-n needs a value: N", ""),
        (PLAIN, "a --clock 2.5", "--clock: '2.5' is not a whole number of at least 0", ""),
        (SHORT, "a --clock -1", "--clock: '-1' is not a whole number of at least 0", ""),
        (PLAIN, "a -n --flag", "-n needs a value: N", ""),
        (PLAIN, "a -n -- 3", "-n needs a value: N", ""),
        (PLAIN, "a -n x", "-n: 'x' is not a whole number of at least 0", ""),
        (PLAIN, "a --clock=x", "--clock: 'x' is not a whole number of at least 0", ""),
        (PLAIN, "a --once b --once c", "--once is given twice", ""),
        (PLAIN, "a --colour alway", "--colour: 'alway' is not one of always, never", "'always'?"),
        (SHORT, "a -fx", "unknown option '-x'", ""),
        (TEXT, "a --x", "unknown option '--x'", ""),
        (SHORT, "-5x", "unknown option '-5x'", ""),
        (SHORT, "-.infx", "unknown option '-.infx'", ""),
        (VERBS, "bogus", "unknown verb 'all bogus'", "known: list, show"),
        (VERBS, "lits", "unknown verb 'all lits'", "did you mean 'list'?"),
    ],
)
def test_mistakes_are_named_with_a_hint(command, line, message, hint):
    with pytest.raises(UsageError) as caught:
        command.parse(line.split())
    assert caught.value.message == message
    assert hint in (caught.value.hint or "")


def test_an_abbreviation_of_two_options_is_none():
    command = Command("x", "", options=(FLAG, option("--flat")), abbreviations=True)
    with pytest.raises(UsageError, match="unknown option '--fla'"):
        command.parse(["--fla"])


def test_options_that_exclude_each_other_are_named():
    command = Command("x", "", options=(FLAG, ONCE), exclusive=(("flag", "once"),))
    assert command.parse(["--flag", "--flag"]).flag is True
    with pytest.raises(UsageError, match="--flag and --once exclude each other"):
        command.parse(["-f", "--once", "a"])


def test_an_option_and_an_argument_may_exclude_each_other():
    command = Command(
        "x", "", arguments=(option("[YAML]"),), options=(FLAG,), exclusive=(("yaml", "flag"),)
    )
    assert (command.parse(["a"]).yaml, command.parse(["-f"]).flag) == ("a", True)
    with pytest.raises(UsageError, match="--flag and YAML exclude each other"):
        command.parse(["a", "--flag"])


@pytest.mark.parametrize("line", ["-h", "a --help", "--bogus -n x --help", "-n -h"])
def test_help_wins_over_mistakes(line):
    with pytest.raises(HelpRequested):
        PLAIN.parse(line.split())


def test_help_behind_two_dashes_is_an_argument():
    assert PLAIN.parse(["--", "--help"]).name == "--help"


def test_all_words_are_read_although_one_is_wrong():
    parsed = PLAIN.read(["--bogus", "a", "-n", "x", "--tag", "b"])
    assert (parsed.name, parsed.tags, parsed.lines) == ("a", ("b",), 100)
    assert parsed.problem.message == "unknown option '--bogus'"


def test_the_help_has_every_option_in_columns():
    lines = help_text(PLAIN).split("\n")
    assert lines[0] == "usage: python -m launcher plain NAME [MORE ...] [options]"
    assert "  -n, --lines N          a number (default: 100)" in lines
    assert "  --colour WHEN          always | never" in lines
    assert "  --maybe[=WORD]" in lines


@pytest.mark.parametrize("word", ["-1", "nan", "inf", "x", ""])
def test_invalid_numbers_of_seconds(word):
    with pytest.raises(ValueError, match=f"'{word}' is not a number of seconds"):
        seconds(word)


@pytest.mark.parametrize(("word", "why"), [("-1", ": it is below 0"), ("x", ""), ("nan", "")])
def test_a_negative_number_of_seconds_is_said_to_be_one(word, why):
    with pytest.raises(ValueError, match=f"'{word}' is not a number of seconds{why}$"):
        seconds(word)


@pytest.mark.parametrize("word", ["-1", "1.5", "²", "x", "", "7"])
def test_invalid_counts(word):
    with pytest.raises(ValueError, match="is not a whole number from 0 to 6"):
        count(word, 0, 6)
