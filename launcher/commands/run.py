"""`run PACKAGE EXECUTABLE [ARG ...]`: one program of a package, in this terminal."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from launcher.errors import ExitCode, UsageError
from launcher.packages import executables, find_executable

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NoReturn

USAGE = "usage: python -m launcher run PACKAGE EXECUTABLE [ARG ...]"


def main(words: Sequence[str]) -> int:
    """Become the program: its terminal, its signals and its exit code are really its own.

    `ros2 run` stays in between and swallows signals (CONFORMANCE 2.3), so we do not.
    """
    words = list(words[1:] if words[:1] == ["--debug"] else words)
    if words and words[0] in ("-h", "--help"):
        print(f"{USAGE}\n\nWhat follows EXECUTABLE goes to it, --ros-args included.")
        return ExitCode.OK
    if not words:
        raise UsageError("the package and the executable are missing", hint=USAGE)
    for word, what in zip(words, ("a package", "an executable"), strict=False):
        if not word or word.startswith(os.sep) or ".." in word.split(os.sep):
            raise UsageError(f"'{word}' is not the name of {what}", hint=USAGE)
    if len(words) == 1:
        names = ", ".join(executables(words[0], os.environ)) or "none"
        raise UsageError("the executable is missing", hint=f"executables of {words[0]}: {names}")
    package, executable, *arguments = words
    program = find_executable(package, executable, os.environ)
    if arguments[:1] == ["--"]:
        arguments = arguments[1:]
    _become([str(program), *arguments])


def _become(argv: list[str]) -> NoReturn:
    sys.stdout.flush()
    sys.stderr.flush()
    os.execv(argv[0], argv)
