"""`args TARGET`: the arguments that a launch file takes, in `ros2 launch --show-args`' words."""

from __future__ import annotations

from collections.abc import Sequence

from launcher.commands.launch import target as command_line
from launcher.commands.launch.redirection import say, stdout_to_stderr
from launcher.commands.launch.time_limit import TimeLimit, limited
from launcher.errors import ExitCode

USAGE = """usage: python -m launcher args TARGET [--debug]
       python -m launcher args PACKAGE FILE

Lists the arguments of the launch file and of the files that it includes.

options:
  --evaluation-timeout S  how long loading may take; 0 for any time (default: 60 s, and 20 s of
                          computing)
  --debug                 show the traceback of an error"""

PATIENCE = ("--evaluation-timeout",)


def main(words: Sequence[str]) -> int:
    """List the arguments of the launch file that `words` name; the exit code."""
    if command_line.wants_help(words):
        say(USAGE)
        return ExitCode.OK
    request = command_line.read(words, verb="args", usage=USAGE.splitlines()[0], valued=(PATIENCE,))
    return show(request.path, TimeLimit.given(request.options.get(PATIENCE[0])))


def show(path: str, patience: TimeLimit) -> int:
    """List the arguments of a launch file; LaunchFileError if it cannot be loaded."""
    from launcher import frontends
    from launcher.language import faults
    from launcher.language.compat import vocabulary
    from launcher.render.arguments import describe_arguments

    with stdout_to_stderr(), limited(patience, path), vocabulary([path]):
        description = frontends.load(path)
        try:
            text = describe_arguments(description.get_launch_arguments())
        except (Exception, SystemExit) as error:
            raise faults.explain(error, path) from error
    say(text)
    return ExitCode.OK
