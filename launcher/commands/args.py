"""`args TARGET`: the arguments that a launch file takes, in `ros2 launch --show-args`' words."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.commands import words as command_line
from launcher.commands.quiet import stdout_to_stderr
from launcher.errors import ExitCode

USAGE = """usage: python -m launcher args TARGET [--debug]
       python -m launcher args PACKAGE FILE

Lists the arguments of the launch file and of the files that it includes."""


def main(words: Sequence[str]) -> int:
    """List the arguments of the launch file that `words` name; the exit code."""
    if command_line.wants_help(words):
        print(USAGE)
        return ExitCode.OK
    request = command_line.read(words, verb="args", usage=USAGE.splitlines()[0])
    return show(request.path)


def show(path: str) -> int:
    """List the arguments of a launch file; LaunchFileError if it cannot be loaded."""
    from launcher import frontends
    from launcher.language.compat import vocabulary
    from launcher.render.arguments import describe_arguments

    with stdout_to_stderr(), vocabulary():
        text = describe_arguments(frontends.load(path).get_launch_arguments())
    print(text)
    return ExitCode.OK
