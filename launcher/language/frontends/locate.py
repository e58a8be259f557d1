"""Finds the launch file that the command line names."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from launcher.base.errors import PackageNotFoundError, UsageError
from launcher.base.program import program
from launcher.base.text import did_you_mean, launch_stem, one_of, shown_path, suggest
from launcher.packages import reading_once
from launcher.packages.finder import (
    executables,
    files_in_share,
    own_package,
    search_prefixes,
    share_directory,
)
from launcher.packages.source_packages import (
    around,
    distributions,
    editable,
    files_in,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from launcher.packages.overlay import Overlay


class WordAfterFileError(UsageError):
    """The first of two words is a launch file, the second one no argument."""

    def __init__(self, path: Path, word: str) -> None:
        super().__init__(
            f"malformed launch argument '{shown_word(word)}', expected format '<name>:=<value>'",
            hint=f"did you mean {shown_word(word)}:=VALUE?",
        )
        self.path = path
        self.word = word


# In hints that say more about a package than a similar name does.
_ANSWERS = ("did you mean", "package.xml", "it is installed in")
SUFFIXES = (".launch.py", ".launch.xml", ".launch.yaml", ".launch.yml")


@reading_once()
def locate(words: Sequence[str], env: Mapping[str, str]) -> Path:
    """The launch file that `TARGET` or `PACKAGE FILE` names; UsageError if there is none.

    TARGET is a path, or the name of a launch file without its suffix: in `launch/` below the
    working directory or one of its parents, then in the share folders of installed packages.
    PACKAGE FILE is looked up as by `ros2 launch`: the file's name anywhere below the package's
    share folder.
    """
    if len(words) == 2:
        return _in_package(words[0], words[1], env)
    (target,) = words
    if not target:
        raise UsageError("the name of the launch file is empty", hint="is a shell variable unset?")
    path = Path(target)
    if _is_file(path):
        return path.absolute()
    if os.path.lexists(path):
        what = "is a directory" if path.is_dir() else "is not a file that can be read"
        raise UsageError(f"'{shown_word(target)}' {what}")
    if path.suffix or os.sep in target:
        raise UsageError(f"launch file '{shown_word(target)}' not found", hint=_near_file(path))
    found = _by_name(target, env)
    if not found:
        here = [path for suffix in SUFFIXES if _is_file(path := Path(f"{target}{suffix}"))]
        known = launch_names(env)
        hint = (
            f"did you mean {one_of(map(str, here))}?"
            if here
            else did_you_mean(target, known)
            or _executable_hint(target, env)
            or _near(target, known)
            or (
                "names are searched in launch/ here and in parent directories, and in installed "
                "packages; or give a path"
            )
        )
        raise UsageError(f"launch file '{shown_word(target)}' not found", hint=hint)
    return _only(target, found)


@reading_once()
def is_launch_file(word: str, env: Mapping[str, str]) -> bool:
    """Whether `locate` finds a launch file, or several, by this word alone."""
    return _is_file(Path(word)) or bool(word and os.sep not in word and _by_name(word, env))


def _near_file(path: Path) -> str | None:
    """The file of this name in `launch/`, else similar ones there or beside the path."""
    folders = [path.parent / "launch"]
    if not path.is_absolute():
        folders += [Path(os.path.relpath(folder)) for folder in _source_folders()]
    beside = [file.name for file in _launch_files(path.parent)]
    below = list(dict.fromkeys(str(file) for folder in folders for file in _launch_files(folder)))
    same = [file for file in below if os.path.basename(file) == path.name]
    if same:
        return f"did you mean '{same[0]}'?"
    return _similar(path, beside) or _similar(path, below) or _near("", beside or below)


def _similar(path: Path, files: Sequence[str]) -> str | None:
    stems = [_stem(Path(file)) for file in files]
    stem = suggest(launch_stem(path.name), stems)  # the suffixes alone make names similar
    near = [file for file, one in zip(files, stems, strict=True) if one == stem]
    return f"did you mean {one_of(near)}?" if near else None


def _launch_files(folder: Path) -> list[Path]:
    return sorted(folder.glob("*.launch.*")) if folder.is_dir() else []


def _own_packages() -> list[str]:
    return sorted({*editable(), *(name for name, _ in around())})


@reading_once()
def executable_command(word: str, env: Mapping[str, str]) -> str | None:
    """`run PACKAGE WORD` if a package of the user has an executable of this name."""
    found = [package for package in _own_packages() if word in executables(package, env)]
    return f"run {found[0]} {word}" if found else None


def _executable_hint(word: str, env: Mapping[str, str]) -> str | None:
    command = executable_command(word, env)
    return command and f"did you mean `{program()} {command}`?"


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name too long for any file
        return False


def shown_word(target: str) -> str:
    """The word for a message: shortened, and encodable."""
    text = shown_path(target).encode(errors="surrogateescape").decode(errors="replace")
    return text if len(text) <= 80 else f"{text[:60]}...{text[-15:]}"


def _by_name(name: str, env: Mapping[str, str]) -> list[Path]:
    for folder in _source_folders():
        found = [folder / f"{name}{suffix}" for suffix in SUFFIXES]
        found = [file for file in found if _is_file(file)]
        if found:
            return found
    return [file for file in _installed_launch_files(env) if _stem(file) == name]


def _source_folders() -> Iterator[Path]:
    """`launch/` of the project that the working directory is in, the nearest first."""
    here = Path.cwd()
    for folder in (here, *here.parents):
        yield folder / "launch"
        if (folder / "package.xml").is_file():
            return


def _installed_launch_files(env: Mapping[str, str]) -> list[Path]:
    files: list[Path] = []
    for prefix in search_prefixes(env):
        for suffix in SUFFIXES:
            files += sorted(prefix.glob(f"share/*/launch/*{suffix}"))
    for package in _own_packages():
        own = own_package(package, env)
        if own is not None:
            folder = Path(own.share, "launch")
            files += sorted(path for path in folder.glob("*") if path.name.endswith(SUFFIXES))
    return list(dict.fromkeys(files))


def _all_launch_files(env: Mapping[str, str]) -> Iterator[Path]:
    for folder in _source_folders():
        for suffix in SUFFIXES:
            yield from folder.glob(f"*{suffix}")
    yield from _installed_launch_files(env)


@reading_once()
def launch_names(env: Mapping[str, str]) -> list[str]:
    """The names that `locate` finds without a path or a package, sorted."""
    return sorted({_stem(file) for file in _all_launch_files(env)})


def _in_package(package: str, file: str, env: Mapping[str, str]) -> Path:
    name, _, value = file.partition("=" if "=" in file else ":")
    if value:
        raise UsageError(
            f"malformed launch argument '{shown_word(file)}', expected format '<name>:=<value>'",
            hint=f"did you mean {name}:={value}?",
        )
    try:
        share = share_directory(package, env)
    except PackageNotFoundError as error:
        meant = [Path(package)] if _is_file(Path(package)) else _by_name(package, env)
        if meant and not file.endswith(SUFFIXES):
            raise WordAfterFileError(meant[0].absolute(), file) from None
        near = suggest(package, {_stem(file) for file in _all_launch_files(env)})
        is_answered = any(words in (error.hint or "") for words in _ANSWERS)
        if near and not is_answered:
            error.hint = f"did you mean the launch file '{near}'?"
        raise
    files = files_in_share(share)
    found = [Path(path) for path in files if os.path.basename(path) == file]
    own = own_package(package, env)
    if not found:
        names = sorted({os.path.basename(path) for path in files if path.endswith(SUFFIXES)})
        raise UsageError(
            f"file '{file}' was not found in the share directory of package '{package}' "
            f"which is at '{share}'",
            hint=_left_out(own, file)
            or _similar(Path(file), names)
            or _installed(own, package, names),
        )
    path = _only(file, found)
    if own is not None and not own.installs(str(path)):
        print(
            f"warning: {path} is not among the data_files of {own.source}/setup.py: it is not "
            "found once the package is installed",
            file=sys.stderr,
        )
    return path


def _left_out(own: Overlay | None, file: str) -> str | None:
    """The hint for a file of the source that setup.py does not install."""
    if own is None or own.share == own.source:
        return None
    paths = (path for path in files_in(own.source) if os.path.basename(path) == file)
    path = next(paths, None)
    return path and f"{path} is not among the data_files of {own.source}/setup.py"


def _installed(own: Overlay | None, package: str, names: Sequence[str]) -> str | None:
    """The launch files that there are; of an installed Python package also why one is missing."""
    available = _near("", names)
    if own is not None or not distributions(package):
        return available
    cause = "only files that setup.py names in data_files are installed"
    return f"{available or 'there is no launch file'}; {cause}"


def _only(name: str, found: list[Path]) -> Path:
    if len(found) > 1:
        raise UsageError(
            f"'{name}' is ambiguous: {', '.join(map(str, found))}",
            hint="give the path of one of them",
        )
    return found[0]


def names_here() -> list[str]:
    """Those of the project that the working directory is in, sorted."""
    files = (file for folder in _source_folders() for file in _launch_files(folder))
    return sorted({_stem(file) for file in files if file.name.endswith(SUFFIXES)})


def _stem(file: Path) -> str:
    return file.name.partition(".launch.")[0]


def _near(name: str, known: Sequence[str]) -> str | None:
    shown = ", ".join(known[:20])
    return did_you_mean(name, known) or (f"available: {shown}" if shown else None)
