"""The table of options that a command line is parsed with."""

from __future__ import annotations

import importlib
from collections.abc import Sequence

from launcher.command_line import Command
from launcher.commands import CONTROL_VERBS, VERBS, module_of


def command_of(words: Sequence[str]) -> tuple[Command, Sequence[str]]:
    """The command that the words begin with, and the words behind its name."""
    verb, *rest = words
    if verb in CONTROL_VERBS:
        from launcher.commands import control
        from launcher.control import verbs

        row = verbs.find(verb)
        return (control.RUNS if row is None else control.command_of(row)), rest
    if verb not in VERBS:
        verb, rest = "launch", list(words)
    command: Command = importlib.import_module(module_of(verb)).COMMAND
    for below in command.commands:
        if rest and below.name == f"{verb} {rest[0]}":
            return below, rest[1:]
    return command, rest
