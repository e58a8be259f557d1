"""The command line of colcon: ours, with the user's words from behind `--`."""

from __future__ import annotations

import re
from collections.abc import Sequence

from launcher.base.errors import UsageError
from launcher.base.program import program
from launcher.workspace.building.build_place import Place

_OURS = {
    "--build-base": "the launcher builds in build/",
    "--install-base": "the launcher installs to install/",
    "--base-paths": "name folders before --, as in: PROGRAM build PATH",
    "--symlink-install": "that is what the launcher does; --copy is the opposite",
}
_SHOWING = ("--event-handlers", "--help", "-h")


def check(words: Sequence[str]) -> None:
    """UsageError for options that the launcher has itself."""
    for word in words:
        flag = word.partition("=")[0]
        if flag in _OURS:
            raise UsageError(
                f"'{flag}' is not for colcon here", hint=_OURS[flag].replace("PROGRAM", program())
            )


def select(words: Sequence[str]) -> bool:
    """Whether the words select packages, so that colcon decides what is built."""
    return any(word.startswith("--packages-") for word in words)


def selecting(words: Sequence[str]) -> list[str]:
    """The options among the words that select packages."""
    chosen: list[str] = []
    is_selecting = False
    for word in words:
        if word.startswith("--"):
            is_selecting = word.startswith("--packages-")
        if is_selecting:
            chosen.append(word)
    return chosen


def ignoring(words: Sequence[str], names: Sequence[str]) -> tuple[str, ...]:
    """The words, with which colcon does not find these packages.

    Of packages that it finds and only leaves out, it demands what they have installed.
    """
    flag = "--packages-ignore"
    if not names:
        return tuple(words)
    for place, word in enumerate(words):
        if word.partition("=")[0] == flag:
            value = [word[len(flag) + 1 :]] if word != flag else []
            return (*words[:place], flag, *value, *names, *words[place + 1 :])
    return (*words, flag, *names)


def show(words: Sequence[str]) -> bool:
    """Whether colcon itself is to write to the terminal."""
    return any(word.partition("=")[0] in _SHOWING for word in words)


def that_count(words: Sequence[str]) -> tuple[str, ...]:
    """The words that change what is built: arguments of CMake and the like."""
    counting: list[str] = []
    is_counted = False
    for word in words:
        if word.startswith("--"):
            flag = word.partition("=")[0]
            is_counted = flag.endswith("-args") or flag in ("--merge-install", "--metas")
        if is_counted:
            counting.append(word)
    return tuple(counting)


def definitions(words: Sequence[str]) -> set[str]:
    """The names of what the words define for CMake: `-DNAME=VALUE`."""
    found = (re.match(r"(--[\w-]*cmake-args=)?\s*-D\s*(\w+)", word) for word in words)
    return {one[2] for one in found if one}


def build(
    place: Place,
    *,
    select: Sequence[str],
    cmake_args: Sequence[str],
    links: bool,
    words: Sequence[str],
) -> list[str]:
    """The words for `colcon`; with `select` only these packages are built."""
    others, theirs = _split(words)
    ours = [one for one in cmake_args if not (one == "-GNinja" and _has_generator(theirs))]
    command = ["build", "--base-paths", place.base, "--build-base", place.build]
    command += ["--install-base", place.install, "--continue-on-error"]
    if links:
        command.append("--symlink-install")
    if place.is_merged and "--merge-install" not in words:
        command.append("--merge-install")
    if select:
        command += ["--packages-select", *select]
    return [*command, *others, "--cmake-args", *ours, *theirs]


def _split(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """The words without those of --cmake-args, and those."""
    others: list[str] = []
    theirs: list[str] = []
    target = others
    for word in words:
        if word.startswith("--"):
            flag, equals, value = word.partition("=")
            target = theirs if flag == "--cmake-args" else others
            if flag == "--cmake-args":
                theirs += [value] if equals else []
                continue
        target.append(word)
    return others, theirs


def _has_generator(words: Sequence[str]) -> bool:
    return any(word.lstrip().startswith("-G") for word in words)
