"""Options in front of a verb: where they end, and that they have their values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from launcher.base.errors import UsageError


def take_front(
    words: Sequence[str], metavars: Mapping[str, str]
) -> tuple[list[list[str]], list[str]]:
    """(each option at the beginning with its value, the words behind them); UsageError.

    `metavars` has the options that may stand there, with the placeholder of their value, if any.
    """
    front: list[list[str]] = []
    left = list(words)
    while left:
        flag, has_value, _ = left[0].partition("=")
        if flag not in metavars:
            break
        size = 2 if metavars[flag] and not has_value else 1
        if len(left) < size:
            raise UsageError(f"{flag} needs a value: {metavars[flag]}")
        front.append(left[:size])
        left = left[size:]
    return front, left
