"""`hosts VERB ...`: check and prepare the hosts of a hosts file."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.command_line import Command
from launcher.commands import VERBS
from launcher.commands.hosts.check import CHECK
from launcher.commands.hosts.schema import SCHEMA
from launcher.commands.hosts.sync import SYNC


def main(words: Sequence[str]) -> int:
    parsed = COMMAND.parse(words)
    assert parsed.command.run is not None
    return parsed.command.run(parsed)


COMMAND = Command("hosts", VERBS["hosts"], commands=(CHECK, SYNC, SCHEMA))
