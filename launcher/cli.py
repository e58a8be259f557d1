"""The command line: a table of verbs; what is no verb is a launch target."""

from __future__ import annotations

import gc
import importlib
import os
import sys
from collections.abc import Sequence

from launcher.errors import (
    ExitCode,
    LauncherError,
    PackageNotFoundError,
    UsageError,
    exit_code_table,
    nearest,
)
from launcher.model.record import Record
from launcher.packages import ament_environment


class Verb(Record):
    """A verb's name, one line of help, and how it is called. Its module is imported when used.

    `module` has `main(words: list[str]) -> int`.
    """

    name: str
    usage: str
    help: str

    @property
    def module(self) -> str:
        """Where it is written."""
        return f"launcher.commands.{self.name}"


VERBS = (
    Verb("launch", "TARGET [name:=value ...]", "run a launch file; `launch` may be left out"),
    Verb("plan", "TARGET [name:=value ...]", "show what a launch file would start, and why"),
    Verb("args", "TARGET", "list the arguments of a launch file"),
    Verb("run", "PACKAGE EXECUTABLE [ARG ...]", "run one program of a package in this terminal"),
    Verb("topic", "VERB ...", "look at topics, listen to them, measure and publish them"),
    Verb("node", "VERB ...", "look at nodes"),
    Verb("param", "VERB ...", "look at and set parameters of nodes"),
    Verb("service", "VERB ...", "look at and call services"),
    Verb("interface", "VERB ...", "look at the types of messages and services"),
    Verb("doctor", "[--fix] [--json]", "find what is wrong on this machine, and mend it"),
    Verb("smoke", "TARGET [name:=value ...]", "test a launch file: what is seen, what is left"),
    Verb("graph", "[OPTIONS]", "show who talks to whom: tree, drawing, page, difference"),
)

# Verbs about a run that is going on: launcher.control.verbs has their table, which is not imported
# on the way to the first process of a run.
CONTROL_MODULE = "launcher.commands.control"
CONTROL_VERBS = (
    "ps",
    "top",
    "kill",
    "stop",
    "start",
    "restart",
    "pause",
    "resume",
    "mute",
    "unmute",
    "solo",
    "level",
    "grep",
    "logs",
    "info",
    "send",
    "events",
    "quit",
    "runs",
)

# Verbs of ros2cli that are not built; launcher.commands.launch.absent_verbs says what there is instead.
ABSENT_VERBS = (
    "action",
    "bag",
    "component",
    "control",
    "daemon",
    "extension_points",
    "extensions",
    "lifecycle",
    "multicast",
    "pkg",
    "plugin",
    "security",
    "test",
    "trace",
    "wtf",
)


def main(words: Sequence[str]) -> int:
    """Run one command line (without the program's name); the exit code."""
    words = list(words)
    # What ROS's own tools get from sourcing a set-up file; children inherit it.
    os.environ.update(ament_environment(os.environ))
    debug = _wants_traceback(words)
    try:
        return _dispatch(words)
    except LauncherError as error:
        if debug:
            raise
        print(error.render(), file=sys.stderr)
        return error.exit_code
    except OSError as error:
        # What we print cannot be written (a full disk); a reader that has gone is told above us.
        if debug or isinstance(error, BrokenPipeError):
            raise
        if error.filename is None and _folder_is_gone():
            gone = UsageError("the folder that you are in is no more", hint="cd to another one")
            print(gone.render(), file=sys.stderr)
            return gone.exit_code
        print(f"error: {error.strerror}: {error.filename or 'output'}", file=sys.stderr)
        return ExitCode.PROCESS_FAILED


def _folder_is_gone() -> bool:
    try:
        os.getcwd()
    except FileNotFoundError:
        return True
    return False


def _wants_traceback(words: list[str]) -> bool:
    verb = words[0] if words else ""
    if verb == "run":
        words = words[:2]  # what follows the executable is not ours to read
    # As with `ros2 launch`; elsewhere -d is something else.
    has_short = verb in ("plan", "args", "launch") or verb not in {v.name for v in VERBS} | set(
        CONTROL_VERBS
    )
    return "--debug" in words or (has_short and "-d" in words)


def _dispatch(words: list[str]) -> int:
    if words[:1] == ["help"]:  # as in the console
        words = _meant_by_help(words[1:])
    if not words or words[0] in ("-h", "--help"):
        print(overview())
        return ExitCode.OK if words else ExitCode.USAGE
    if words[0] in ("--version", "-V"):
        print(importlib.import_module("launcher").__version__)
        return ExitCode.OK
    if words[0].partition("=")[0] == "--run":
        raise UsageError("--run goes behind the verb", hint="as in python -m launcher ps --run ID")
    if words[0] in CONTROL_VERBS:
        steered: int = importlib.import_module(CONTROL_MODULE).main(words)
        return steered
    verb = next((v for v in VERBS if v.name == words[0]), None)
    if verb is None:
        if words[0] in ABSENT_VERBS:
            importlib.import_module("launcher.commands.launch.absent_verbs").refuse(words)
        verb, rest = VERBS[0], words
    else:
        rest = words[1:]
    if verb is not VERBS[0]:
        gc.enable()
    try:
        code: int = importlib.import_module(verb.module).main(rest)
    except (UsageError, PackageNotFoundError) as error:
        if rest is words:
            _suggest_verb(words[0], error)
        raise
    return code


def _meant_by_help(words: list[str]) -> list[str]:
    """The words that print what `help` and these words ask for; UsageError."""
    if not words or words[0] == "help" or words[0].startswith("-"):
        return ["--help"]
    name = words[0]
    names = [*(verb.name for verb in VERBS), *CONTROL_VERBS]
    if name not in (*names, *ABSENT_VERBS):
        near = nearest(name, names)
        hint = f"python -m launcher help {near}" if near else "python -m launcher help"
        raise UsageError(f"there is no verb '{name}'", hint=hint)
    below = words[1:2] if name in _WITH_VERBS and not words[-1].startswith("-") else []
    return [name, *below, "--help"]


_WITH_VERBS = ("topic", "node", "param", "service", "interface")  # they have verbs of their own


def _suggest_verb(word: str, error: LauncherError) -> None:
    """Add to what is wrong with a target that it looks like a misspelt verb."""
    near = nearest(word, [*(v.name for v in VERBS), *CONTROL_VERBS])
    if near is not None and f"'{word}'" in error.message:
        meant = f"did you mean python -m launcher {near}?"
        error.hint = f"{meant} ({error.hint})" if error.hint else meant


def overview() -> str:
    """What `--help` prints: the verbs and the exit codes."""
    lines = [
        "usage: python -m launcher TARGET [name:=value ...]",
        "       python -m launcher VERB ...        (python -m launcher VERB --help tells more)",
        "",
        "TARGET is a launch file, the name of one (`system` for launch/system.launch.py), or",
        "PACKAGE FILE as with `ros2 launch`.",
        "",
        "verbs:",
        *(f"  {verb.name:9} {verb.help}" for verb in VERBS),
        "",
        "verbs about a run that is going on, from any shell:",
        *(f"  {name:9} {text}" for name, text in control_verbs()),
        "",
        *exit_code_table(),
    ]
    return "\n".join(lines)


def control_verbs() -> list[tuple[str, str]]:
    """(name, one line of help) of the verbs about a run that is going on."""
    from launcher.control.verbs import VERBS as CONTROL

    table = [(verb.name, verb.help) for verb in CONTROL if verb.shell]
    return [*table, ("runs", "list the runs that are going on")]


__all__ = ["VERBS", "UsageError", "Verb", "main", "overview"]
