"""`hosts schema`: print the JSON Schema of hosts files."""

from __future__ import annotations

from launcher.command_line import DEBUG, Command, Parsed
from launcher.errors import ExitCode
from launcher.stdio import print_text


def _print(parsed: Parsed) -> int:
    from launcher import strict_json
    from launcher.hosts.schema import json_schema

    print_text(strict_json.dumps(json_schema(), indent=2, ensure_ascii=False))
    return ExitCode.OK


SCHEMA = Command(
    "hosts schema",
    "print the JSON Schema of hosts files, for editors",
    options=(DEBUG,),
    run=_print,
)
