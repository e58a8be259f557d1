"""`hosts VERB ...`: check and prepare the hosts of a hosts file."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.base.command_line import Command, Parsed
from launcher.base.errors import ExitCode
from launcher.base.option import DEBUG
from launcher.base.verb_table import VERBS
from launcher.hosts.verbs.check import CHECK
from launcher.hosts.verbs.sync import SYNC
from launcher.posix.stdio import print_text


def _print(parsed: Parsed) -> int:
    from launcher.base import strict_json
    from launcher.hosts.file.schema import json_schema

    print_text(strict_json.dumps(json_schema(), indent=2, ensure_ascii=False))
    return ExitCode.OK


SCHEMA = Command(
    "hosts schema",
    "print the JSON Schema of hosts files, for editors",
    options=(DEBUG,),
    run=_print,
)


def main(words: Sequence[str]) -> int:
    parsed = COMMAND.parse(words)
    assert parsed.command.run is not None
    return parsed.command.run(parsed)


COMMAND = Command("hosts", VERBS["hosts"], commands=(CHECK, SYNC, SCHEMA))
