"""Words: what a command line that names a launch file says."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

from launcher.errors import UsageError
from launcher.frontends.arguments import split_words
from launcher.frontends.locate import locate
from launcher.model.record import Record

DEBUG = ("--debug", "-d")


class LaunchRequest(Record):
    """The launch file, its arguments in order, and the options by their first spelling.

    `options` holds "" for an option that takes no value.
    """

    path: str
    arguments: tuple[tuple[str, str], ...]
    options: Mapping[str, str]


def wants_help(words: Sequence[str]) -> bool:
    """Whether the help is asked for."""
    return "-h" in words or "--help" in words


def read(
    words: Sequence[str],
    *,
    verb: str,
    usage: str,
    flags: Sequence[tuple[str, ...]] = (),
    valued: Sequence[tuple[str, ...]] = (),
) -> LaunchRequest:
    """The words with the launch file located; UsageError.

    `flags` and `valued` are options with all their spellings; those of `valued` take the next
    word, or what follows a `=`. Options may stand anywhere in front of a `--`.
    """
    spellings = {word: option[0] for option in (DEBUG, *flags, *valued) for word in option}
    with_value = {option[0] for option in valued}
    options: dict[str, str] = {}
    plain: list[str] = []
    rest = iter(words)
    for word in rest:
        if word == "--":
            plain += rest
        elif not _is_option(word):
            plain.append(word)
        else:
            name, equals, value = word.partition("=")
            option = spellings.get(name)
            if option is None or (equals and option not in with_value):
                raise _unknown(word, verb, list(spellings))
            if option in with_value and not equals:
                value = _value_after(name, next(rest, None))
            options[option] = value
    targets, arguments = split_words(plain)
    if not targets:
        raise UsageError("the launch file is missing", hint=usage)
    path = str(locate(targets, os.environ))
    return LaunchRequest(path=path, arguments=tuple(arguments), options=options)


def _is_option(word: str) -> bool:
    return word.startswith("-") and len(word) > 1


def _value_after(option: str, word: str | None) -> str:
    if word is None:
        raise UsageError(f"{option} wants a value", hint=f"{option}=VALUE")
    return word


def _unknown(word: str, verb: str, known: Sequence[str]) -> UsageError:
    import difflib

    near = difflib.get_close_matches(word, known, n=1)
    hint = f"did you mean {near[0]}?" if near else f"python -m launcher {verb} --help"
    return UsageError(f"unknown option '{word}'", hint=hint)
