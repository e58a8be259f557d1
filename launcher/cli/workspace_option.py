"""`--workspace DIR`, which may stand in front of a verb or among the words behind it."""

from __future__ import annotations

import os
from collections.abc import Sequence

from launcher.base.command_line import HelpRequested
from launcher.base.errors import UsageError
from launcher.base.option import WORKSPACE
from launcher.base.program import program
from launcher.base.verb_table import CONTROL_VERBS, VERBS
from launcher.cli.lookup import command_of, verbs_first
from launcher.packages.workspace import VARIABLE, absolute

_FLAG = WORKSPACE.flags[0]


def choose_workspace(words: Sequence[str]) -> list[str]:
    """Choose the workspace that the words name, also for child processes; the other words.

    Words that are arguments of a program to run, or that are wrong, are left as they are.
    """
    chosen, left = None, verbs_first(words)
    for place in (0, 1):  # in front of the verb, and of the verb's own verb
        while len(left) > place and left[place].partition("=")[0] == _FLAG:
            chosen = _value(left, place)
            if place == 0:
                _check_front(chosen, left)
    if any(word.partition("=")[0] == _FLAG for word in left):
        command, rest = command_of(left)
        try:
            parsed = command.read(rest)
        except (HelpRequested, UsageError):
            return left
        if parsed.problem is None:
            given = [part for one, part, _ in parsed.given if one is not WORKSPACE]
            left = [*left[: len(left) - len(rest)], *(word for part in given for word in part)]
            chosen = chosen if parsed.workspace is None else parsed.workspace
    if chosen is not None:
        os.environ[VARIABLE] = absolute(os.path.expanduser(chosen)) if chosen else ""
    return left


def _check_front(value: str, rest: Sequence[str]) -> None:
    """UsageError if nothing follows the option, or its value is the verb that should follow."""
    is_verb = value in (*VERBS, *CONTROL_VERBS)
    if rest and (not is_verb or os.path.isdir(value)):
        return
    command = " ".join((value, *rest)) if is_verb else "TARGET|VERB ..."
    raise UsageError(
        f"{_FLAG} needs a folder, and '{value}' is taken for it"
        if is_verb
        else f"a launch target or verb is missing behind {_FLAG} {value}",
        hint=f"{program()} {_FLAG} {WORKSPACE.metavar if is_verb else value} {command}",
    )


def _value(words: list[str], place: int) -> str:
    """Take the option at this place out of the words; its value."""
    _, separator, value = words.pop(place).partition("=")
    if separator:
        return value
    if place >= len(words):
        raise UsageError(f"{_FLAG} needs a value: {WORKSPACE.metavar}")
    return words.pop(place)
