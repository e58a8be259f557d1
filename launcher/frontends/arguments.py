"""Arguments: the `name:=value` words of a command line."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence

from launcher.errors import UsageError


def split_words(words: Iterable[str]) -> tuple[list[str], list[tuple[str, str]]]:
    """(the words that name the launch file, the arguments in order); UsageError.

    As with `ros2 launch`, the first `:=` separates and the last of two equal names counts.
    """
    targets: list[str] = []
    arguments: list[tuple[str, str]] = []
    for word in words:
        name, separator, value = word.partition(":=")
        if not separator:
            _expect_target(word, targets, arguments)
            targets.append(word)
            continue
        if not name or not value:
            raise UsageError(
                f"malformed launch argument '{word}', expected format '<name>:=<value>'",
                hint="a value cannot be empty; without the argument its default counts",
            )
        arguments.append((name, value))
    return targets, arguments


def _expect_target(word: str, targets: Sequence[str], arguments: Sequence[tuple[str, str]]) -> None:
    if not arguments and len(targets) < 2:
        return
    name, _, value = word.partition("=" if "=" in word else ":")
    hint = f"did you mean {name}:={value}?" if value else None
    raise UsageError(
        f"malformed launch argument '{word}', expected format '<name>:=<value>'", hint=hint
    )


def check_names(arguments: Iterable[tuple[str, str]], known: Sequence[str]) -> None:
    """UsageError that names every argument which is not known, with the nearest one that is."""
    unknown = [name for name, _ in arguments if name not in known]
    if not unknown:
        return
    listed = ", ".join(known) or "none"
    hints = []
    for name in dict.fromkeys(unknown):
        near = difflib.get_close_matches(name, known, n=1)
        hints.append(f"did you mean {near[0]}?" if near else f"arguments there are: {listed}")
    names = ", ".join(f"'{name}'" for name in dict.fromkeys(unknown))
    plural = "s" if len(set(unknown)) > 1 else ""
    raise UsageError(
        f"unknown launch argument{plural} {names}", hint="; ".join(dict.fromkeys(hints))
    )
