"""The arguments that a launch file declares, without an evaluation of what is in it."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Sequence

from launcher.base.command_line import UnknownOptionError
from launcher.base.errors import LauncherError
from launcher.base.text import suggest
from launcher.language import frontends
from launcher.language.compat import vocabulary
from launcher.language.frontends.locate import locate
from launcher.language.substitution import describe_substitutions
from launcher.launch.time_limit import TimeLimit, limited
from launcher.posix.stdio import silence, stdout_to_stderr

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.language.actions.arguments import DeclareLaunchArgument

SWITCH = ("true", "false")
_READ_S = 5.0  # for a launch file
_LIKENESS = 0.8  # of names


def declared_arguments(path: str) -> list[DeclareLaunchArgument]:
    """The arguments of a launch file and of what it includes; LauncherError."""
    limit = TimeLimit(wall_s=_READ_S, cpu_s=_READ_S)
    with stdout_to_stderr(), limited(limit, path), vocabulary([path]):
        return list(frontends.load(path).get_launch_arguments())


def default_of(argument: DeclareLaunchArgument) -> str:
    """Its default as text; empty without one."""
    default = argument.default_value
    return "" if default is None else describe_substitutions(default).strip("'")


def explain_option(
    error: UnknownOptionError, words: Sequence[str], given: Sequence[str], flags: Iterable[str]
) -> None:
    """Change the hint if the launch file has an argument of this name: `--enable-debug`.

    It says how arguments are written if a value is given and the name is near to nothing.

    `words` are those that are no option, the target among them, `given` are all of them, and
    `flags` the options, which a misspelt name may be nearer to.
    """
    flag, has_value, value = error.word.partition("=")
    if not flag.startswith("--"):
        return
    declared: list[DeclareLaunchArgument] | None = None
    with contextlib.suppress(Exception, SystemExit), silence():
        declared = declared_arguments(_target([word for word in words if ":=" not in word]))
    if declared is None:  # it is not found, or cannot be read
        return
    known = {_plain(argument.name): argument for argument in declared}
    name = _plain(flag)
    is_off = name not in known and name.removeprefix("no_") in known
    name = name.removeprefix("no_") if is_off else name
    near = name if name in known else suggest(name, [*known, *map(_plain, flags)], _LIKENESS)
    if near is not None and near in known:
        argument = known[near]
        meant = value if has_value else _value(argument, given, error.word, is_off=is_off)
        error.hint = f"did you mean {argument.name}:={meant}?"
        return
    value = value or _behind(given, error.word)
    is_after_target = words[0] in given[: list(given).index(error.word)]
    if value and is_after_target and (error.hint or "").startswith("usage: "):
        listed = ", ".join(argument.name for argument in declared) or "no argument"
        error.hint = (
            f"launch arguments are written {name}:={value}; this launch file declares {listed}"
        )


def _plain(name: str) -> str:
    return name.lstrip("-").replace("-", "_")


def _target(words: Sequence[str]) -> str:
    """The launch file that one or two of the words name; UsageError."""
    with contextlib.suppress(LauncherError):
        return str(locate(words[:1], os.environ))
    return str(locate(words[:2], os.environ))


def _value(
    argument: DeclareLaunchArgument, given: Sequence[str], word: str, *, is_off: bool
) -> str:
    """What the option without `=` stands for: the word behind it, or that it is switched on."""
    if is_off:
        return "false"
    if default_of(argument).lower() in SWITCH:
        return "true"
    return _behind(given, word) or "VALUE"


def _behind(given: Sequence[str], word: str) -> str:
    """The word behind an option if it may be its value; else empty."""
    behind = list(given)[list(given).index(word) + 1 :]
    return behind[0] if behind and behind[0][:1] != "-" and ":=" not in behind[0] else ""
