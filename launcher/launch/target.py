"""The launch file that a command line names, its arguments, and the options about reading it."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence

from launcher.base.command_line import Command, Parsed, UnknownOptionError
from launcher.base.errors import UsageError
from launcher.base.model.record import Record
from launcher.base.option import option, seconds
from launcher.base.text import shown_path
from launcher.launch.time_limit import TimeLimit

SYNOPSIS = "TARGET [name:=value ...] [options]"
ABOUT_TARGET = """\
TARGET is a launch file, the name of one (`system` for launch/system.launch.py), or PACKAGE FILE
as with `ros2 launch`."""

TARGET = option("[TARGET ...]", name="words")
LENIENT = option("--lenient", "accept unknown names of launch arguments, as ROS 2 does")
NONINTERACTIVE = option("-n, --noninteractive", "tell the launch file that there is no terminal")
PREFIX = option("--launch-prefix WORDS", "put words in front of the commands")
PREFIX_FILTER = option(
    "--launch-prefix-filter REGEX", "with --launch-prefix: only in front of commands that match"
)
DEBUG = option("-d, --debug", "show debug messages, and the traceback of an error")
MAX_SECONDS = 1e6


def _limit(text: str) -> TimeLimit:
    limit_s = seconds(text)
    if limit_s > MAX_SECONDS:
        raise ValueError(f"'{text}' is more than {MAX_SECONDS:.0f} s; 0 is no limit")
    return TimeLimit(wall_s=limit_s, cpu_s=limit_s)


EVALUATION_TIMEOUT = option(
    "--evaluation-timeout S",
    "how long reading the launch file may take; 0 for no limit (default: 60 s, and 20 s of "
    "processor time)",
    _limit,
    TimeLimit(),
    name="time_limit",
)
# Options that `smoke` takes as well.
READING_OPTIONS = (
    LENIENT,
    NONINTERACTIVE,
    PREFIX,
    PREFIX_FILTER,
    EVALUATION_TIMEOUT,
    DEBUG,
)


class LaunchRequest(Record):
    """The launch file, its arguments in order, and how it is read; `log_name`: of its log file."""

    path: str
    arguments: tuple[tuple[str, str], ...] = ()
    lenient: bool = False
    noninteractive: bool = False
    debug: bool = False
    log_name: str = "launch"
    time_limit: TimeLimit = TimeLimit()

    @classmethod
    def of(cls, parsed: Parsed) -> LaunchRequest:
        """The request of a parsed command line, with the path of the launch file; UsageError."""
        targets, arguments = split_words(parsed.words, parsed.command)
        if not targets:
            usage = f"usage: {parsed.command.usage}"
            raise UsageError("the launch file is missing", hint=usage)
        given = vars(parsed)
        prefix, pattern = given.get("launch_prefix"), given.get("launch_prefix_filter")
        if prefix is not None:
            arguments.append(("launch-prefix", prefix))
        if pattern is not None:
            if prefix is None:
                raise UsageError(
                    "--launch-prefix must be specified if --launch-prefix-filter is provided"
                )
            arguments.append(("launch-prefix-filter", pattern))
        return cls(
            path=_launch_file(targets, parsed.command),
            arguments=tuple(arguments),
            lenient=given.get("lenient", False),
            noninteractive=given.get("noninteractive", False),
            debug=given.get("debug", False),
            log_name=given.get("log_name", "launch"),
            time_limit=parsed.time_limit,
        )


def parse_words(command: Command, words: Sequence[str]) -> Parsed:
    """The parsed words of a command about a launch file; UsageError, HelpRequested."""
    parsed = read_words(command, words)
    if parsed.problem is not None:
        raise parsed.problem
    return parsed


def read_words(command: Command, words: Sequence[str]) -> Parsed:
    """As `parse_words`, but the first mistake is the `problem` of what is returned."""
    parsed = command.read(words)
    if isinstance(parsed.problem, UnknownOptionError):
        from launcher.launch.declared_arguments import explain_option

        explain_option(parsed.problem, parsed.words, words, _flags(command))
    return parsed


def _flags(command: Command) -> list[str]:
    return [flag for option in command.all_options for flag in option.flags]


def _launch_file(words: Sequence[str], command: Command) -> str:
    """The absolute path of the launch file; UsageError."""
    if len(words) == 1 and os.path.isfile(words[0]):
        return shown_path(os.path.join(os.getcwd(), words[0].removeprefix("./")))
    # Imports pathlib, which takes 3 ms.
    from launcher.language.frontends.locate import WordAfterFileError, locate

    try:
        return shown_path(str(locate(words, os.environ)))
    except WordAfterFileError as error:
        from launcher.launch.mistakes import explain_word

        raise explain_word(error, _flags(command)) from None


_EMPTY_VALUE = "a value cannot be empty; omit the argument to use its default"


def split_words(
    words: Iterable[str], command: Command | None = None
) -> tuple[list[str], list[tuple[str, str]]]:
    """(the words that name the launch file, the arguments in order); UsageError.

    As with `ros2 launch`, the first `:=` separates and the last of two equal names counts. A word
    that is neither may be an option of `command` without its dashes.
    """
    targets: list[str] = []
    arguments: list[tuple[str, str]] = []
    for word in words:
        name, separator, value = word.partition(":=")
        if not separator:
            if arguments or len(targets) == 2:
                raise _no_argument(word, targets, command)
            targets.append(word)
            continue
        if not name or not value:
            raise UsageError(
                f"malformed launch argument '{word}', expected format '<name>:=<value>'",
                hint=_EMPTY_VALUE if name else "the name is missing",
            )
        arguments.append((name, value))
    return targets, arguments


def _no_argument(word: str, targets: Sequence[str], command: Command | None) -> UsageError:
    name, _, value = word.partition("=" if "=" in word else ":")
    if not value and len(targets) == 2 and targets[-1].isidentifier():
        name, value = targets[-1], word
    hint = f"did you mean {name}:={value}?" if value else None
    if command is not None and f"--{word}" in _flags(command):
        hint = f"did you mean --{word}?"
    return UsageError(
        f"malformed launch argument '{word}', expected format '<name>:=<value>'", hint=hint
    )
