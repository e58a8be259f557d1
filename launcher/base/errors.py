"""Errors for users, and exit codes.

    LauncherError            exit code 1
    +-- SeveralErrors        independent errors; exit code of the first
    +-- UsageError           exit code 2
    |   +-- UnknownVerbError
    +-- LaunchFileError      exit code 2
        +-- PackageNotFoundError
        +-- ExecutableNotFoundError

`launcher.cli.dispatch.main` prints them.
"""

from __future__ import annotations

import enum
from collections.abc import Iterable, Sequence

from launcher.base.text import escape


class ExitCode(enum.IntEnum):
    """Exit codes of the launcher, with their meaning for `--help`."""

    OK = 0
    PROCESS_FAILED = 1
    USAGE = 2
    NOT_MET = 3
    NOT_READY = 124
    INTERRUPTED = 130
    TERMINATED = 143

    @property
    def meaning(self) -> str:
        return _MEANINGS[self]


_MEANINGS = {
    ExitCode.OK: "all processes exited as expected, or were stopped on request",
    ExitCode.PROCESS_FAILED: "a process died, was killed or did not start, a host could not be "
    "reached, or the launcher failed",
    ExitCode.USAGE: "bad command line or bad launch file, or something to install is missing; "
    "nothing was started",
    ExitCode.NOT_MET: "smoke: an expectation was not met",
    ExitCode.NOT_READY: "smoke: the system was not ready in time",
    ExitCode.INTERRUPTED: "stopped by Ctrl-C (SIGINT), and a process was killed or had died, or "
    "before anything was started",
    ExitCode.TERMINATED: "stopped by SIGTERM, SIGHUP or SIGQUIT, and a process was killed or had "
    "died, or before anything was started",
}


def exit_code_table(codes: Iterable[ExitCode] = ExitCode) -> list[str]:
    return ["exit codes:", *(f"  {code.value:<8} {code.meaning}" for code in codes)]


_LONGEST_LINE = 200  # of a source file, in a message
OF_SMOKE = (ExitCode.NOT_MET, ExitCode.NOT_READY)


class LauncherError(Exception):
    """An error with a place and a hint.

    `message` is one sentence; `hint` says what to do; `where` is `file:line`; `source_line` and
    `column` (from 1) are printed below them.
    """

    exit_code: ExitCode = ExitCode.PROCESS_FAILED

    def __init__(
        self,
        message: str,
        *,
        hint: str | None = None,
        where: str | None = None,
        source_line: str | None = None,
        column: int | None = None,
    ) -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint
        self.where = where
        self.source_line = source_line
        self.column = column

    def render(self) -> str:
        """The error as it is printed, without colour, in one to four lines."""
        head = f"{self.where}: {self.message}" if self.where else self.message
        lines = [f"error: {head}"]
        if self.source_line is not None:
            lines += _pointed_at(self.source_line, self.column)
        if self.hint:
            lines.append(f"hint: {self.hint}")
        return escape("\n".join(lines))


def _pointed_at(line: str, column: int | None) -> list[str]:
    """The line, or what is around the column of a very long one, with a mark below it."""
    start = 0
    if len(line) > _LONGEST_LINE:
        start = max(0, (column or 1) - 1 - _LONGEST_LINE // 2)
        line = line[start : start + _LONGEST_LINE]
    shown = [f"    {line}"]
    return shown if column is None else [*shown, "    " + " " * (column - 1 - start) + "^"]


class SeveralErrors(LauncherError):
    """Independent errors that are shown together."""

    def __init__(self, errors: Sequence[LauncherError]) -> None:
        first = errors[0]
        super().__init__(first.message, hint=first.hint, where=first.where)
        self.errors = tuple(errors)
        self.exit_code = first.exit_code

    def render(self) -> str:
        return "\n".join(error.render() for error in self.errors)


class UsageError(LauncherError):
    """The command line is wrong."""

    exit_code = ExitCode.USAGE


class UnknownVerbError(UsageError):
    """The first word is no verb and nothing to launch; --debug shows no traceback of it."""


class LaunchFileError(LauncherError):
    """The launch file, or what it refers to, is wrong."""

    exit_code = ExitCode.USAGE


class PackageNotFoundError(LaunchFileError):
    """No prefix and no installed distribution has the package."""


class ExecutableNotFoundError(LaunchFileError):
    """The package has no such executable."""
