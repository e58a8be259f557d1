"""The table of options that a command line is parsed with."""

from __future__ import annotations

import contextlib
import importlib
from collections.abc import Sequence

from launcher.base.command_line import Command
from launcher.base.errors import UsageError
from launcher.base.verb_table import ALIASES, CONTROL_VERBS, VERBS, module_of


def verbs_first(words: Sequence[str]) -> list[str]:
    """The same command line without options between a verb and its own verb."""
    if len(words) > 1 and words[0] in VERBS and words[1].startswith("-"):
        command: Command = importlib.import_module(module_of(words[0])).COMMAND
        if command.commands:
            with contextlib.suppress(UsageError):
                front, rest = command.take_front(words[1:])
                moved = [part for option in front for part in option]
                return [words[0], *rest[:1], *moved, *rest[1:]]
    return list(words)


def command_of(words: Sequence[str]) -> tuple[Command, Sequence[str]]:
    """The command that the words begin with, and the words behind its name."""
    verb, *rest = words
    verb = ALIASES.get(verb, verb)
    if verb in CONTROL_VERBS:
        from launcher.control import verb as control
        from launcher.control import verbs

        row = verbs.find(verb)
        return (control.RUNS if row is None else control.command_of(row)), rest
    if verb not in VERBS:
        verb, rest = "launch", list(words)
    elif verb == "demo":
        from launcher.launch.verbs.demo import launch_words

        verb, rest = "launch", launch_words(rest)
    command: Command = importlib.import_module(module_of(verb)).COMMAND
    if not command.commands:
        return command, rest
    with contextlib.suppress(UsageError):
        rest = command.take_front(rest)[1]
    for below in command.commands:
        if rest and below.name == f"{verb} {rest[0]}":
            return below, rest[1:]
    return command, rest
