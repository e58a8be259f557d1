"""`args TARGET`: list the arguments of a launch file, as `ros2 launch --show-args` prints them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from launcher.base.command_line import Command
from launcher.base.errors import ExitCode
from launcher.base.verb_table import VERBS
from launcher.language.substitution import describe_substitutions
from launcher.launch.target import (
    ABOUT_TARGET,
    DEBUG,
    EVALUATION_TIMEOUT,
    TARGET,
    LaunchRequest,
    parse_words,
)
from launcher.launch.time_limit import limited
from launcher.posix.stdio import print_text, stdout_to_stderr

if TYPE_CHECKING:
    from launcher.language.actions.arguments import DeclareLaunchArgument


COMMAND = Command(
    "args",
    VERBS["args"],
    arguments=(TARGET,),
    synopsis="TARGET [options]",
    about=f"List the arguments of the launch file and of what it includes.\n\n{ABOUT_TARGET}",
    options=(EVALUATION_TIMEOUT, DEBUG),
)


def main(words: Sequence[str]) -> int:
    """List the arguments of the launch file that `words` name; the exit code."""
    return show(LaunchRequest.of(parse_words(COMMAND, words)))


def show(request: LaunchRequest) -> int:
    """List the arguments of a launch file; LaunchFileError if it cannot be loaded."""
    from launcher.language import frontends
    from launcher.language.compat import vocabulary
    from launcher.language.diagnostics import faults

    path = request.path
    with stdout_to_stderr(), limited(request.time_limit, path), vocabulary([path]):
        description = frontends.load(path)
        try:
            text = describe_arguments(description.get_launch_arguments())
        except (Exception, SystemExit) as error:
            raise faults.explain(error, path) from error
    print_text(text)
    return ExitCode.OK


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
