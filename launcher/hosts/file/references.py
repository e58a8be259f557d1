"""Paths of this machine as references that mean the same on another host."""

from __future__ import annotations

import functools
import os
import re
import sys
from collections.abc import Mapping, Sequence

from launcher.base.errors import LauncherError
from launcher.base.model.record import Record
from launcher.packages import source_packages
from launcher.packages.finder import own_package, share_directory
from launcher.packages.source_packages import MARKERS


class ExecutableReference(Record):
    """The executable of a package."""

    package: str
    name: str


class SharedFile(Record):
    """A file or folder in the share folder of a package; `path` is relative to it."""

    package: str
    path: str


class SentFile(Record):
    """A file that is sent with the order, by its name in `Order.files`."""

    name: str


class InterpreterReference(Record):
    """The Python interpreter of the launcher there."""


class Inherited(Record):
    """The value that the host's environment has for a variable; empty without one."""

    variable: str


Part = str | ExecutableReference | SharedFile | SentFile | InterpreterReference | Inherited
Word = tuple[Part, ...]  # joined without anything in between

# Folders of the operating system, which has the same files on every host.
_OF_SYSTEM = ("/bin/", "/dev/", "/etc/", "/lib", "/proc/", "/sbin/", "/sys/", "/usr/")
_PATH = re.compile(r"(?:(?<=file://)|(?<![^\s'\":=,;(\[{]))/(?!/)[^\s'\":=,;)\]}]+")


def is_of_system(path: str) -> bool:
    return path.startswith(_OF_SYSTEM)


def is_interpreter(path: str) -> bool:
    """Whether it is the Python of this environment."""
    folder, _, name = path.rpartition("/")
    return path == sys.executable or (
        folder == os.path.join(sys.prefix, "bin") and name.startswith("python")
    )


def executable_at(path: str) -> ExecutableReference | None:
    """The executable of a package, by its path in `lib`."""
    folder, _, name = path.rpartition("/")
    head, lib, package = folder.rpartition("/lib/")
    is_of_package = bool(lib) and "/" not in package and os.path.isfile(path)
    if is_of_package and os.path.isfile(f"{head}/{MARKERS}/{package}"):
        return ExecutableReference(package, name)
    return None


def shared_at(path: str, environ: Mapping[str, str]) -> SharedFile | None:
    """The path below the share folder of a package; None elsewhere."""
    path = os.path.normpath(path)
    for found in re.finditer("/share/", path):
        package, _, rest = path[found.end() :].partition("/")
        head = path[: found.start()]
        if package and package != "ament_index" and _has_share(head, package, environ):
            return SharedFile(package, rest)
    return _in_source(path, environ)


def _has_share(head: str, package: str, environ: Mapping[str, str]) -> bool:
    if os.path.isfile(f"{head}/{MARKERS}/{package}"):
        return True
    if not os.path.isfile(f"{head}/share/{package}/package.xml"):
        return False
    try:  # of an installed distribution without an entry in the index
        return str(share_directory(package, environ)) == f"{head}/share/{package}"
    except LauncherError:
        return False


def _in_source(path: str, environ: Mapping[str, str]) -> SharedFile | None:
    """A file of a package whose source folder serves as its share folder."""
    for name, folder in _source_folders(os.getcwd()):
        if f"{path}/".startswith(f"{folder}/"):
            own = own_package(name, environ)
            is_file_of_it = own is not None and (os.path.isdir(path) or own.installs(path))
            if own is not None and own.share == folder and is_file_of_it:
                return SharedFile(name, path[len(folder) + 1 :])
    return None


@functools.lru_cache(maxsize=1)
def _source_folders(cwd: str) -> tuple[tuple[str, str], ...]:
    """(name, folder) of packages that are used from their source; a search of many folders."""
    return (*source_packages.editable().items(), *source_packages.around())


def with_references(text: str, environ: Mapping[str, str]) -> Word:
    """The text, with references for the paths in it that lead to a share folder."""
    parts: list[Part] = []
    end = 0
    for found in _PATH.finditer(text):
        shared = shared_at(found[0], environ) if os.path.exists(found[0]) else None
        if shared is not None:
            parts += [text[end : found.start()], shared]
            end = found.end()
    parts.append(text[end:])
    return joined(parts)


def paths_in(text: str) -> list[str]:
    """The paths in a text that exist here and are not of the operating system."""
    found = (path[0] for path in _PATH.finditer(text))
    return [path for path in found if os.path.exists(path) and not is_of_system(path)]


def joined(parts: Sequence[Part]) -> Word:
    """The parts as a word: without empty ones, texts beside each other in one."""
    word: list[Part] = []
    for part in parts:
        if isinstance(part, str) and word and isinstance(word[-1], str):
            word[-1] += part
        elif part != "":
            word.append(part)
    return tuple(word) or ("",)


def plain(word: Word) -> str | None:
    """The word if it has no references."""
    return str(word[0]) if len(word) == 1 and isinstance(word[0], str) else None
