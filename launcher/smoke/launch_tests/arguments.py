"""Arguments `name:=value` of a test of launch_testing."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any


def parse_launch_arguments(launch_arguments: Iterable[str]) -> list[tuple[str, str]]:
    """Pairs of name and value, the last one of each name. RuntimeError for another form."""
    values: dict[str, str] = {}
    for argument in launch_arguments:
        name, separator, value = argument.partition(":=")
        if not name or not separator or not value:
            raise RuntimeError(
                f"malformed launch argument '{argument}', expected format '<name>:=<value>'"
            )
        values[name] = value
    return list(values.items())


def hint_of(argument: str) -> str | None:
    """What a malformed argument was probably meant to be."""
    name, _, value = argument.partition("=")
    return f"did you mean {name}:={value}?" if name.isidentifier() and value else None


def print_arguments_of_launch_description(*, launch_description: Any) -> None:
    """Print the declared arguments with their descriptions and defaults."""
    print("Arguments (pass arguments as '<name>:=<value>'):")
    arguments = launch_description.get_launch_arguments()
    for argument in arguments:
        mark = "*" if argument._conditionally_included else ""
        print(f"\n    '{argument.name}':{mark}\n        {argument.description}")
        if argument.default_value is not None:
            default = " + ".join(token.describe() for token in argument.default_value)
            print(f"        (default: {default})")
    if not arguments:
        print("\n  No arguments.")
    elif any(argument._conditionally_included for argument in arguments):
        print("\n* argument(s) which are only used if specific conditions occur")
