"""The error for a word that is no verb here: of ros2cli, of the console, of others, or misspelt."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence

from launcher.base.errors import LauncherError, PackageNotFoundError, UnknownVerbError, UsageError
from launcher.base.program import program
from launcher.base.synonyms import REST, SYNONYMS, TARGET, meant_lines
from launcher.base.text import several, suggest
from launcher.base.verb_table import ABSENT_VERBS, CONSOLE_VERBS, CONTROL_VERBS, VERBS
from launcher.cli.overview import control_verbs
from launcher.language.frontends.locate import (
    SUFFIXES,
    executable_command,
    is_launch_file,
    launch_names,
    shown_word,
)
from launcher.packages import reading_once
from launcher.packages.finder import files_in_share, share_directory


@reading_once()
def refuse(words: Sequence[str]) -> None:
    """UnknownVerbError unless a launch file or a package has the name of this verb."""
    verb = words[0]
    if not _is_target(words):
        if verb in CONSOLE_VERBS:
            message = f"'{verb}' exists only in the console of a running launch"
        else:
            message = f"ros2cli's verb '{verb}' does not exist here"
        hint = {**ABSENT_VERBS, **CONSOLE_VERBS}[verb] or "PROGRAM --help lists the verbs"
        raise UnknownVerbError(message, hint=hint.replace("PROGRAM", program()))


def _is_target(words: Sequence[str]) -> bool:
    is_package = len(words) > 1 and _share(words[0]) is not None
    return is_package or is_launch_file(words[0], os.environ)


def _share(package: str) -> str | None:
    try:
        return str(share_directory(package, os.environ))
    except PackageNotFoundError:
        return None


@reading_once()
def explained(words: Sequence[str], error: LauncherError | None = None) -> LauncherError | None:
    """The error about these words, which begin with no verb; that given if it is about others.

    A first word that names no file, launch file or package was meant to be a verb.
    """
    word = words[0]
    is_path = word in ("", os.curdir, os.pardir) or any(one in word for one in (os.sep, "=", "."))
    if is_path or word.startswith("-") or _is_target(words):
        return error
    share = _share(word)
    if share is not None:
        return _without_file(word, share)
    beside = [f"{word}{suffix}" for suffix in SUFFIXES]
    lines = meant_lines(word, (*VERBS, *CONTROL_VERBS))
    if any(map(os.path.isfile, beside)) or (os.path.lexists(word) and not lines):
        return error  # a folder such as log/ does not hide what a word means
    behind = [one for one in words[1:] if not one.startswith("-")]
    if error is not None and behind[:1] and behind[0].endswith(SUFFIXES):
        meant = f"did you mean `{program()} {lines[0]}`?" if lines else None
        error.hint = f"{meant} ({error.hint})" if meant and error.hint else meant or error.hint
        return error
    what = "launch file or package" if behind else "launch file"
    message = f"unknown verb '{shown_word(word)}', and there is no {what} of this name"
    return UnknownVerbError(message, hint=_meant(words, behind, error))


def _without_file(package: str, share: str) -> UsageError:
    paths = sorted(files_in_share(share), key=lambda path: (path.count(os.sep), path))
    names = [os.path.basename(path) for path in paths if path.endswith(SUFFIXES)]
    message = f"'{package}' is a package, and no launch file has this name"
    if not names:
        return UsageError(message, hint="it has no launch file")
    example = f"for example: {program()} {package} {names[0]}"
    return UsageError(message, hint=f"launch files of the package: {several(names)}; {example}")


def _meant(words: Sequence[str], behind: Sequence[str], error: LauncherError | None) -> str:
    """The hint: what the words may mean, or what there is."""
    names = launch_names(os.environ)
    choices = list(dict.fromkeys(_choices(words, behind, names)))
    if choices:
        *some, last = (f"`{program()} {line}`" for line in choices)
        meant = f"{', '.join(some)} or {last}" if some else last
        return f"did you mean {meant}?{_about(words[0], choices)}"
    if isinstance(error, PackageNotFoundError) and (error.hint or "").startswith("did you mean"):
        return error.hint or ""
    listed = f"launch files: {several(names, 20)}; " if names else ""
    return f"{listed}{program()} --help lists the verbs"


def _choices(words: Sequence[str], behind: Sequence[str], names: Sequence[str]) -> Iterator[str]:
    """Command lines that the words may mean, without the program."""
    word = words[0]
    executable = executable_command(word, os.environ)
    if executable is not None:
        yield executable
        if word not in SYNONYMS:
            return
    if word in ("list", "ls") and behind and behind[0] in SYNONYMS:
        yield from SYNONYMS[behind[0]]  # `list nodes`
        return
    targets = (one for one in behind if one in names or one.endswith(SUFFIXES))
    target = next(targets, TARGET)
    for line in meant_lines(word, (*VERBS, *CONTROL_VERBS)):
        if line == REST:
            yield from [" ".join(words[1:])] if words[1:] else []
        else:
            yield line.replace(TARGET, target)
    name = None if word in SYNONYMS else suggest(word, names)
    if name is not None:
        yield name


def _about(word: str, choices: Sequence[str]) -> str:
    """The row of the verb that a word of another program stands for, as `--help` prints it."""
    verb = choices[0]
    text = {**VERBS, **dict(control_verbs())}.get(verb)
    return f"\n  {verb:9} {text}" if text and word in SYNONYMS and len(choices) == 1 else ""
