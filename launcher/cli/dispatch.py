"""The command line: its first word is a verb, or else a launch target."""

from __future__ import annotations

import gc
import importlib
import os
import sys
from collections.abc import Sequence

from launcher.base.command_line import HelpRequested
from launcher.base.errors import (
    ExitCode,
    LauncherError,
    PackageNotFoundError,
    UnknownVerbError,
    UsageError,
)
from launcher.base.option import HELP
from launcher.base.verb_table import (
    ABSENT_VERBS,
    ALIASES,
    CONSOLE_VERBS,
    CONTROL_VERBS,
    ROS_FRONT,
    ROS_VERBS,
    VERBS,
    module_of,
)
from launcher.packages.distribution import source_installation, title
from launcher.packages.workspace import current


def main(words: Sequence[str]) -> int:
    """Run one command line (without the program's name); the exit code."""
    words = list(words)
    source_installation()
    debug = False
    try:
        if words[:1] and words[0].startswith("-") and len(words) > 1:
            words = list(importlib.import_module(ROS_FRONT).verb_first(words))
        debug = _wants_traceback(words)
        if any(word.partition("=")[0] == "--workspace" for word in words):
            from launcher.cli.workspace_option import choose_workspace

            words = choose_workspace(words)
        return _dispatch(words)
    except LauncherError as error:
        if debug and not isinstance(error, UnknownVerbError):
            raise
        print(error.render(), file=sys.stderr)
        return error.exit_code
    except ModuleNotFoundError as error:
        from launcher.cli.absent_modules import absent_module

        absent = None if debug else absent_module(error)
        if absent is None:
            raise
        print(absent.render(), file=sys.stderr)
        return absent.exit_code
    except OSError as error:
        # Output cannot be written (a full disk); __main__ handles closed pipes.
        if debug or isinstance(error, BrokenPipeError):
            raise
        if error.filename is None and _folder_is_gone():
            gone = UsageError("the current directory does not exist any more")
            print(gone.render(), file=sys.stderr)
            return gone.exit_code
        if error.filename is None:
            from launcher.posix.stdio import report_lost_output

            report_lost_output(error, sys.stdout)
        else:
            print(f"error: {error.strerror}: {error.filename}", file=sys.stderr)
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
        words = words[:2]  # the rest are arguments of the executable
    # As with `ros2 launch`; with other verbs -d is something else.
    has_short = verb in ("plan", "args", "launch", "demo") or verb not in (*VERBS, *CONTROL_VERBS)
    return "--debug" in words or (has_short and "-d" in words)


def _dispatch(words: list[str]) -> int:
    if words[:1] == ["--"]:  # no options can precede the verb or target
        words = words[1:]
    if words[:1] == ["help"]:  # as in the console
        words = _help_words(words[1:])
    if not words or words[0] in HELP.flags:
        from launcher.cli.overview import first_steps, overview

        print(overview(is_whole="--all" in words) if words else first_steps())
        return ExitCode.OK if words else ExitCode.USAGE
    verb, *rest = words
    verb = ALIASES.get(verb, verb)
    if verb in ("--version", "-V"):
        print(f"{importlib.import_module('launcher').__version__} ({title()})")
        return ExitCode.OK
    if verb.partition("=")[0] == "--run":
        raise UsageError(
            "--run is an option of a verb", hint=f"for example: {_program()} ps --run ID"
        )
    if verb in CONTROL_VERBS:
        return _run("control", words)
    if verb in VERBS:
        return _run(verb, rest)
    if verb in ABSENT_VERBS or verb in CONSOLE_VERBS:
        importlib.import_module("launcher.cli.absent_verbs").refuse(words)
    return _launch(words)


def _launch(words: list[str]) -> int:
    """Run the launch file that the words name; LauncherError, also for what is no verb."""
    try:
        if any(word in HELP.flags for word in words):
            _refuse_unknown(words)
        return _run("launch", words)
    except (UsageError, PackageNotFoundError) as error:
        if words == ["version"]:  # as with git and go; a launch file of this name would have run
            return _dispatch(["--version"])
        _refuse_unknown(words, error)
        raise


def _refuse_unknown(words: list[str], error: LauncherError | None = None) -> None:
    """Raise the error about a first word that is no verb, no launch file and no package."""
    from launcher.cli.absent_verbs import explained

    better = explained(words, error)
    if better is not None and better is not error:
        raise better from None


# Verbs that need nothing of a workspace, or make it.
_OUTSIDE_WORKSPACE = (
    "control",
    "doctor",
    "env",
    "build",
    "wheel",
    "pkg",
    "multicast",
    "daemon",
)
# Verbs that leave rclpy to other processes. In this one, the loader would have to know the
# libraries of a workspace from the start.
_WITHOUT_RCLPY = (
    "launch",
    "plan",
    "args",
    "run",
    "demo",
    "smoke",
    "interface",
    "completion",
    "test",
    "hosts",
    "agent",
    "mcp",
)


def enter_workspace(verb: str = "launch") -> None:
    """Make the workspace of the working directory visible; UsageError."""
    workspace = current()
    if workspace is None:
        return
    from launcher.packages import activation

    activation.activate(workspace, warns=verb != "completion")
    if verb not in _WITHOUT_RCLPY:
        activation.load_libraries(workspace)


def _run(module: str, words: list[str]) -> int:
    if module != "launch":
        gc.enable()
    if module not in _OUTSIDE_WORKSPACE:
        enter_workspace(module)
    try:
        code: int = importlib.import_module(module_of(module)).main(words)
    except HelpRequested as requested:
        from launcher.base.command_help import help_text

        print(help_text(requested.command))
        return requested.exit_code
    return code


def _help_words(words: list[str]) -> list[str]:
    """The words that print the help requested by `help WORDS`; UsageError."""
    if not words or words[0] == "help" or words[0].startswith("-"):
        return ["--help", *words]
    name = ALIASES.get(words[0], words[0])
    names = (*VERBS, *CONTROL_VERBS)
    if name not in (*names, *ABSENT_VERBS, *CONSOLE_VERBS):
        from launcher.base.synonyms import meant_verb

        hint = meant_verb(name, names) or f"{_program()} help lists the verbs"
        raise UsageError(f"unknown verb '{name}'", hint=hint)
    below = words[1:2] if name in _WITH_VERBS and not words[-1].startswith("-") else []
    return [name, *below, "--help"]


# Those with subcommands.
_WITH_VERBS = (*(verb for verb in ROS_VERBS if verb not in ("graph", "foxglove")), "pkg", "hosts")


def _program() -> str:
    from launcher.base.program import program  # only help and hints need it

    return program()
