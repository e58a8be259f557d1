"""The arguments of a launch file, as `ros2 launch --show-args` prints them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from launcher.language.substitution import describe_substitutions

if TYPE_CHECKING:
    from launcher.language.actions.arguments import DeclareLaunchArgument


def describe_arguments(arguments: Sequence[DeclareLaunchArgument]) -> str:
    blocks = ["Arguments (pass arguments as '<name>:=<value>'):"]
    blocks += [_describe(argument) for argument in arguments]
    if not arguments:
        blocks.append("  No arguments.")
    if any(argument._conditionally_included for argument in arguments):
        blocks.append("* argument(s) which are only used if specific conditions occur")
    return "\n\n".join(blocks)


def _describe(argument: DeclareLaunchArgument) -> str:
    star = "*" if argument._conditionally_included else ""
    lines = [f"    '{argument.name}':{star}", f"        {argument.description}"]
    if argument.default_value is not None:
        lines.append(f"        (default: {describe_substitutions(argument.default_value)})")
    return "\n".join(lines)
