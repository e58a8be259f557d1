"""`daemon status|start|stop`: for scripts that were written for ros2cli."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode
from launcher.base.option import DEBUG
from launcher.base.verb_table import VERBS


def _print_none(options: Parsed) -> int:
    print("There is no daemon, and none is needed: every verb reads the graph itself")
    return ExitCode.OK


def _command(verb: str) -> Command:
    return Command(f"daemon {verb}", "say that there is none", options=(DEBUG,), run=_print_none)


COMMAND = Command(
    "daemon", VERBS["daemon"], commands=tuple(map(_command, ("status", "start", "stop")))
)


def main(words: Sequence[str]) -> int:
    parsed = COMMAND.parse(words)
    assert parsed.command.run is not None
    return parsed.command.run(parsed)
