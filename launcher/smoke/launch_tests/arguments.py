"""Arguments `name:=value` of a test of launch_testing."""

from __future__ import annotations


def hint_of(argument: str) -> str | None:
    """What a malformed argument was probably meant to be."""
    name, _, value = argument.partition("=")
    return f"did you mean {name}:={value}?" if name.isidentifier() and value else None
