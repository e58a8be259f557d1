"""`TARGET [name:=value ...]`: run a launch file until its processes have ended."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from launcher.errors import ExitCode, UsageError
from launcher.frontends.arguments import check_names, split_words
from launcher.frontends.locate import locate

if TYPE_CHECKING:
    from launcher.interpreter import Interpreter

USAGE = """usage: python -m launcher TARGET [name:=value ...] [--debug]
       python -m launcher PACKAGE FILE [name:=value ...] [--debug]

TARGET is a launch file or the name of one: `system` for launch/system.launch.py.
Ctrl-C stops everything in order: SIGINT, after 5 s SIGTERM, after 5 s more SIGKILL; pressed
again it does not wait.

options:
  --debug    show the traceback of an error"""


def main(words: Sequence[str]) -> int:
    """Run the launch file that `words` name; the exit code."""
    if "-h" in words or "--help" in words:
        print(USAGE)
        return ExitCode.OK
    options = [word for word in words if word.startswith("-")]
    unknown = [option for option in options if option != "--debug"]
    if unknown:
        raise UsageError(f"unknown option '{unknown[0]}'", hint="python -m launcher launch --help")
    targets, arguments = split_words(word for word in words if word not in options)
    if not targets:
        raise UsageError("the launch file is missing", hint=USAGE.splitlines()[0])
    path = str(locate(targets, os.environ))
    return launch(path, arguments)


def launch(path: str, arguments: Sequence[tuple[str, str]]) -> int:
    """Evaluate the launch file, then run what it describes."""
    from launcher import frontends
    from launcher.interpreter import Interpreter
    from launcher.language.compat import vocabulary

    with vocabulary():
        description = frontends.load(path)
        declared = [argument.name for argument in description.get_launch_arguments()]
        check_names(arguments, declared)
        interpreter = Interpreter(description, path=path, arguments=arguments)
        try:
            code = _supervise(interpreter)
        finally:
            interpreter.close()
    if interpreter.failure is not None:
        print(interpreter.failure.render(), file=sys.stderr)
        return ExitCode.PROCESS_FAILED
    return code


def _supervise(interpreter: Interpreter) -> ExitCode:
    from launcher.engine.reactor import Reactor
    from launcher.engine.screen import Screen, wants_colour
    from launcher.engine.supervisor import Supervisor

    environment = dict(os.environ)
    with Reactor() as reactor:
        screen = Screen(reactor, colour=wants_colour(1, environment))
        return Supervisor(
            interpreter,
            env=environment,
            reactor=reactor,
            screen=screen,
            run_id=_new_run_id(),
        ).run()


def _new_run_id() -> str:
    return f"{os.getpid()}-{os.urandom(6).hex()}"
