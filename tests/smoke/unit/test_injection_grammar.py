"""The words of an injection, its mistakes, and its expressions for schemas."""

from __future__ import annotations

import re

import pytest

from launcher.base.document.fields import FieldError
from launcher.run.part_verbs import WHAT
from launcher.smoke.inject.grammar import KINDS, parsed, parsed_line, patterns


@pytest.mark.parametrize(
    ("text", "values", "for_s"),
    [
        ("pause", {}, 5.0),
        ("slow 4 for 500 ms", {"factor": 4.0}, 0.5),
        ("kill", {}, None),
        ("drop /a/b", {"topic": "/a/b"}, 5.0),
        ("drop /a/b 50 % for 2 min", {"topic": "/a/b", "percent": 50.0}, 120.0),
        ("delay /a 200", {"topic": "/a", "delay_s": 0.2}, 5.0),
        ("delay  /a  2 s for 3", {"topic": "/a", "delay_s": 2.0}, 3.0),
        ("cpu", {}, 5.0),
        ("cpu 2", {"cores": 2}, 5.0),
        ("memory 200 MB", {"size": 200 << 20}, 5.0),
        ("disk 1G", {"leave": 1 << 30}, 5.0),
    ],
)
def test_words_are_read(text: str, values: dict[str, object], for_s: float | None):
    injection = parsed(text)
    assert (dict(injection.values), injection.for_s) == (values, for_s)


@pytest.mark.parametrize(
    ("text", "says", "hint"),
    [
        ("slwo 4", "unknown injection 'slwo'", "did you mean 'slow'?"),
        ("slow", "slow needs FACTOR", "usage: slow FACTOR"),
        ("slow 1", "slow: '1' is not a factor above 1", "usage: slow FACTOR"),
        ("slow four", "slow: 'four' is not a number", "usage: slow FACTOR"),
        ("pause 3", "pause: unexpected '3'", "usage: pause"),
        ("kill for 3 s", "kill takes no time", None),
        ("pause for 0 s", "must be greater than 0 s", None),
        ("drop scan", "'scan' is not the full name of a topic", "as in /robot_1/scan"),
        ("drop /scan 0", "'0' is not a percentage above 0", "usage: drop TOPIC [PERCENT]"),
        ("delay /scan", "delay needs MS", "usage: delay TOPIC MS"),
        ("memory much", "memory: invalid size 'much'", "usage: memory SIZE"),
        ("memory 0 MB", "memory: '0 MB' is not a size above 0", "usage: memory SIZE"),
        ("cpu 0", "'0' is not a number of cores", "usage: cpu [CORES]"),
    ],
)
def test_mistakes_have_a_hint(text: str, says: str, hint: str | None):
    with pytest.raises(FieldError, match=re.escape(says)) as found:
        parsed(text)
    assert found.value.hint == hint


def test_lines_begin_with_a_name():
    assert parsed_line("robot_* slow 4")[0] == "robot_*"
    for line, says in (("machine pause", "about a process"), ("pause", "invalid injection")):
        with pytest.raises(FieldError, match=says):
            parsed_line(line)


def test_the_expressions_of_schemas_fit_what_is_read():
    expressions = list(patterns())
    for expression, example in expressions:
        assert re.fullmatch(expression, example)
        assert parsed_line(example)
        assert not re.fullmatch(expression, f"{example} more")
    assert WHAT.choices == tuple(KINDS)
