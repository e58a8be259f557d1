"""Which packages a build may try: those without mistakes, and not built from any with one."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from launcher.base.errors import ExitCode, SeveralErrors, UsageError
from launcher.base.program import program
from launcher.base.text import count, did_you_mean
from launcher.workspace.building import checks, sources
from launcher.workspace.building.build_place import Place
from launcher.workspace.building.colcon import colcon_arguments, colcon_options
from launcher.workspace.building.sources import FoundPackages, Package
from launcher.workspace.building.sources.source_text import SourceError, SourceWarning

_NAMING = ("--packages-select", "--packages-up-to", "--packages-skip")


class BuildRefusedError(SeveralErrors):
    """Packages that cannot be built: all that is wrong with them, and how to build the others."""

    def __init__(self, errors: Sequence[SourceError], others: int) -> None:
        super().__init__(errors)
        self.exit_code = ExitCode.USAGE
        self._others = others

    def render(self) -> str:
        if not self._others:
            return super().render()
        hint = (
            f"hint: nothing was built; `{program()} build --keep-going` builds the "
            f"{count(self._others, 'package')} without mistakes"
        )
        return f"{super().render()}\n{hint}"


@dataclass(frozen=True)
class Approved:
    """The packages to build, dependencies first, and the names of those that cannot be.

    `selected` are the names that options of colcon select; None without such options.
    """

    packages: tuple[Package, ...]
    refused: tuple[str, ...] = ()
    selected: frozenset[str] | None = None


def approved(
    place: Place, environ: Mapping[str, str], words: Sequence[str] = (), *, keep_going: bool = False
) -> Approved:
    """The packages that the build of a place may try: the named ones and what they need.

    Warnings are printed. RefusedError if there are mistakes; with `keep_going` they are printed,
    and the packages left out that have them, or are built from one that has. `words` are colcon's,
    and may select packages by name.
    """
    found = sources.find([place.base], environ)
    named = _named(found, place)
    selected = None
    if colcon_arguments.select(words):
        _check_names(found, words)
        chosen = _selected(found, place, words)
        if not chosen:
            raise UsageError(f"'{' '.join(colcon_arguments.selecting(words))}' selects no package")
        selected = frozenset(chosen & named)
    checked = named if place.named and selected is None else selected
    problems = checks.check(
        found,
        environ,
        install=place.install,
        only=checked,
        definitions=colcon_arguments.definitions(words),
        is_merged=place.is_merged or "--merge-install" in words,
    )
    _print(checks.warnings(problems))
    errors = checks.errors(problems)
    refused = _refused(found, errors) & named if errors else set()
    left = [one for one in found.packages if one.name in named - refused]
    if errors and not keep_going:
        others = {one.name for one in left} & (named if checked is None else checked)
        raise BuildRefusedError(errors, len(others))
    _print(errors)
    return Approved(tuple(sources.in_order(left)), tuple(sorted(refused)), selected)


def _refused(found: FoundPackages, errors: Iterable[SourceError]) -> set[str]:
    """The packages with errors, and those that need one to be built."""
    names = {error.package for error in errors if error.package}
    names |= sources.in_cycles(found.packages)
    return sources.with_dependents(found.everything, names, "build")


def _named(found: FoundPackages, place: Place) -> set[str]:
    """The packages that the command line names, with what they need; all if it names none."""
    if not place.named:
        return {package.name for package in found.everything}
    folders = {os.path.realpath(folder) for folder in place.named}
    named = [one.name for one in found.everything if os.path.realpath(one.folder) in folders]
    return sources.with_dependencies(found.everything, named)


def _selected(found: FoundPackages, place: Place, words: Sequence[str]) -> set[str]:
    """The packages that options of colcon select; it is asked for others than the usual ones."""
    chosen = {package.name for package in found.everything}
    for flag, names in _selections(words):
        if flag == "--packages-select":
            chosen &= {*names}
        elif flag == "--packages-up-to":
            chosen &= sources.with_dependencies(found.everything, names)
        elif flag == "--packages-skip":
            chosen -= {*names}
        elif flag.startswith("--packages-"):
            return colcon_options.selected(place, colcon_arguments.selecting(words))
    return chosen


def _check_names(found: FoundPackages, words: Sequence[str]) -> None:
    """UsageError for names that no package has; those to skip need not exist."""
    known = {one.name for one in found.everything}
    for flag, names in _selections(words):
        for name in [one for one in names if flag in _NAMING and one not in known]:
            message = f"{flag}: there is no package '{name}' in the workspace"
            hint = did_you_mean(name, sorted(known))
            if flag != "--packages-skip":
                raise UsageError(message, hint=hint)
            _print([SourceWarning(message, hint=hint)])


def _selections(words: Sequence[str]) -> list[tuple[str, list[str]]]:
    """The options of colcon with their values."""
    options: list[tuple[str, list[str]]] = []
    for word in words:
        if word.startswith("--"):
            flag, equals, value = word.partition("=")
            options.append((flag, [value] if equals else []))
        elif options:
            options[-1][1].append(word)
    return options


def _print(problems: Iterable[SourceError]) -> None:
    for problem in problems:
        print(problem.render(), file=sys.stderr)
