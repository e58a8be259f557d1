"""`run PACKAGE EXECUTABLE [ARG ...]`: run one executable of a package in this terminal."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Sequence

from launcher.base.command_line import Command
from launcher.base.errors import LauncherError, PackageNotFoundError, UsageError
from launcher.base.option import DEBUG, option
from launcher.base.program import program
from launcher.base.verb_table import VERBS
from launcher.output.logs.run_directory import provide_log_root
from launcher.packages.finder import executables, find_executable
from launcher.posix.dispositions import for_exec

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NoReturn


def _words(text: str) -> list[str]:
    """The words of a command, at least one; ValueError."""
    words = shlex.split(text)
    if not words:
        raise ValueError("it is empty")
    return words


COMMAND = Command(
    "run",
    VERBS["run"],
    arguments=(
        option("PACKAGE"),
        option("[EXECUTABLE]"),
        option("[ARG ...]", default=(), name="words", count="..."),
    ),
    synopsis="[options] PACKAGE EXECUTABLE [ARG ...]",
    about="""\
Run one executable of a package in this terminal. All words after EXECUTABLE are its arguments,
--ros-args included.""",
    options=(
        option("--prefix COMMAND", "run it by this command: 'gdb -ex run --args'", _words),
        DEBUG,
    ),
)


def main(words: Sequence[str]) -> int:
    """Replace this process by the program, which then has the terminal and gets all signals.

    `ros2 run` stays its parent and swallows signals (CONFORMANCE 2.3).
    """
    parsed = COMMAND.parse(words)
    package, executable = parsed.package, parsed.executable
    for word, what in ((package, "a package"), (executable, "an executable")):
        if word is not None and (not word or word[0] == os.sep or ".." in word.split(os.sep)):
            hint = _of_file(word) or f"usage: {COMMAND.usage}"
            raise UsageError(f"'{word}' is not the name of {what}", hint=hint)
    if executable is None:
        raise _without_executable(package)
    try:
        found = str(find_executable(package, executable, os.environ))
    except PackageNotFoundError as error:
        error.hint = _of_file(package) or error.hint
        raise
    argv = [*(parsed.prefix or []), found, *parsed.words]
    provide_log_root(os.environ)
    try:
        _become(argv)
    except OSError as error:
        if parsed.prefix is None:
            raise
        hint = "it is the command in front of the executable"
        raise UsageError(f"--prefix: {argv[0]}: {error.strerror}", hint=hint) from None


def _without_executable(package: str) -> LauncherError:
    """The error for one word, which may name an executable or a launch file as well."""
    try:
        names = ", ".join(executables(package, os.environ)) or "none"
    except PackageNotFoundError as error:
        from launcher.language.frontends.locate import executable_command, launch_names

        is_launch_file = package in launch_names(os.environ)
        meant = package if is_launch_file else executable_command(package, os.environ)
        near = f"did you mean `{program()} {meant}`?" if meant else error.hint
        error.hint = _of_file(package) or near
        return error
    return UsageError("the executable is missing", hint=f"executables of {package}: {names}")


def _of_file(word: str) -> str | None:
    """The hint for the path of a file in the place of a package; None if it is none."""
    if not os.path.isfile(word):
        return None
    from launcher.language.frontends.locate import SUFFIXES

    path = shlex.quote(word)
    if word.endswith(SUFFIXES):
        return f"did you mean `{program()} {path}`?"
    command = f"python3 {path}" if word.endswith(".py") else path if os.sep in path else f"./{path}"
    return f"it is a file, and `run` takes a package; a file needs no package: `{command}`"


def _become(argv: list[str]) -> NoReturn:
    sys.stdout.flush()
    sys.stderr.flush()
    with for_exec():
        os.execvp(argv[0], argv)
