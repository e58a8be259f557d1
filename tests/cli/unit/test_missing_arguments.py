"""Every command names the first of its arguments that is missing."""

from __future__ import annotations

import re

import pytest

from launcher.base.command_line import Command
from launcher.base.errors import UsageError
from launcher.base.option import Option
from launcher.base.run_verb import Verb
from launcher.control import verb as control
from launcher.control import verbs
from tools.command_reference import commands


def needed(argument: Option) -> list[str]:
    """The names of the words that an argument has at least."""
    return argument.metavar.split() if argument.count in "1+" else []


CASES = [
    pytest.param(command, given, id=f"{command.name} with {given}")
    for command in commands()
    for given in range(sum(len(needed(one)) for one in command.arguments))
]


@pytest.mark.parametrize(("command", "given"), CASES)
def test_the_first_argument_that_is_missing_is_named(command: Command, given: int):
    names = [(name, one) for one in command.arguments for name in needed(one)]
    words = [one.choices[0] if one.choices else "word" for _, one in names[:given]]
    with pytest.raises(UsageError) as caught:
        command.parse(words)
    assert caught.value.message.split(" after ")[0] == f"{names[given][0]} is missing"
    assert caught.value.hint == f"usage: {command.usage}"


def needed_in_a_run(verb: Verb) -> list[str]:
    """The same of a verb about a run, whose arguments are those of its usage."""
    return re.findall(r"\b[A-Z]+\b", re.sub(r"\[.*?\]", "", verb.usage))


OF_A_RUN = [
    pytest.param(verb, given, id=f"{verb.name} with {given}")
    for verb in verbs.VERBS
    for given in range(len(needed_in_a_run(verb)))
]


@pytest.mark.parametrize(("verb", "given"), OF_A_RUN)
def test_a_verb_about_a_run_names_what_is_missing(verb: Verb, given: int):
    with pytest.raises(UsageError) as caught:
        verbs.call_of(verb, control.command_of(verb).parse(["word"] * given))
    name = needed_in_a_run(verb)[given]
    title = "the name of a process" if name == "NAME" else name
    assert caught.value.message.partition(":")[0] == f"{verb.name} needs {title}"
