"""`hosts VERB ...`: check and prepare the hosts of a hosts file."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.base.command_line import Command
from launcher.base.verb_table import VERBS
from launcher.hosts.verbs.check import CHECK
from launcher.hosts.verbs.schema import SCHEMA
from launcher.hosts.verbs.sync import SYNC


def main(words: Sequence[str]) -> int:
    parsed = COMMAND.parse(words)
    assert parsed.command.run is not None
    return parsed.command.run(parsed)


COMMAND = Command("hosts", VERBS["hosts"], commands=(CHECK, SYNC, SCHEMA))
