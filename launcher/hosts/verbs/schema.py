"""`hosts schema`: print the JSON Schema of hosts files."""

from __future__ import annotations

from launcher.base.command_line import DEBUG, Command, Parsed
from launcher.base.errors import ExitCode
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
