"""Splits the command line into launch file and `name:=value` arguments."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from launcher.errors import UsageError

_EMPTY_VALUE = "a value cannot be empty; omit the argument to use its default"


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
                hint=_EMPTY_VALUE if name else "the name is missing",
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
