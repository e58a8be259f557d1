"""Which files a process has loaded, found without running it."""

from __future__ import annotations

import functools
import importlib
import os
import sys
from collections.abc import Iterator, Mapping, Sequence

from launcher.base.model.record import Record, replace
from launcher.packages.imports import imports_of, is_installed
from launcher.packages.python_program import PythonProgram, program_of

_SYSTEM = ("/usr/", "/bin/", "/sbin/", "/lib", "/opt/ros/")  # changes there are no edits


class PythonSource(Record):
    """A Python program: a script or a module; `folder` is the first one of its `sys.path`."""

    folder: str
    script: str
    module: str


class WatchedProgram(Record):
    """A command as it was started; `parameters` are the parameter files of the user.

    `members` are the commands of the nodes that it runs itself, instead of its own. `sources` has,
    for each command, what it runs (None: no Python); empty until it is `resolved`.
    """

    argv: tuple[str, ...]
    env: Mapping[str, str]
    cwd: str | None = None
    parameters: tuple[str, ...] = ()
    members: tuple[tuple[str, ...], ...] = ()
    sources: tuple[PythonSource | None, ...] = ()

    @property
    def commands(self) -> tuple[tuple[str, ...], ...]:
        return self.members or (self.argv,)

    @property
    def parameter_files(self) -> list[str]:
        return [_absolute(path, self.cwd) for path in self.parameters]


def resolved(program: WatchedProgram, before: WatchedProgram | None = None) -> WatchedProgram:
    """The same with `sources`: what it runs stays known while its script is deleted.

    `before` is the program of the last start, when the script may not have been deleted yet.
    """
    sources = [_source(argv, program) for argv in program.commands]
    if before is not None and before.commands == program.commands:
        sources = [now or old for now, old in zip(sources, before.sources, strict=True)]
    return replace(program, sources=tuple(sources))


def files_of(program: WatchedProgram) -> list[str]:
    """The absolute paths of its own source files and parameter files, the program first."""
    known = program if program.sources else resolved(program)
    found = zip(known.commands, known.sources, strict=True)
    paths = [path for argv, source in found for path in _files(argv, source, known)]
    paths += known.parameter_files
    return list(dict.fromkeys(os.path.normpath(path) for path in paths))


def _files(argv: Sequence[str], source: PythonSource | None, program: WatchedProgram) -> list[str]:
    if source is None:
        return list(_executable(argv, program))
    path = (source.folder, *_python_path(program), *_own_path())
    files = _imports(source.script, source.module, path)
    return [_absolute(file, program.cwd) for file in files]


@functools.cache
def _imports(script: str, module: str, path: tuple[str, ...]) -> list[str]:
    return imports_of(script=script, module=module, path=path).files


def forget_imports() -> None:
    """Files have changed; until then processes of one program share what was found."""
    _imports.cache_clear()
    importlib.invalidate_caches()


def _source(argv: Sequence[str], program: WatchedProgram) -> PythonSource | None:
    """The Python program that a command runs, also behind a prefix."""
    cwd = program.cwd or os.getcwd()
    for start in range(len(argv)):
        if argv[start] == "--ros-args":
            break
        found = program_of(argv[start:], program.env, program.cwd)
        if isinstance(found, PythonProgram) and found.module:
            return PythonSource(cwd, "", found.module)
        if isinstance(found, PythonProgram):
            return _script(_absolute(found.script, cwd))
    for word in argv:  # of another interpreter, or with options of it
        path = _absolute(word, cwd)
        if word.endswith(".py") and os.path.isfile(path):
            return _script(path)
    return None


def _script(path: str) -> PythonSource:
    return PythonSource(os.path.dirname(os.path.realpath(path)), path, "")


def _executable(argv: Sequence[str], program: WatchedProgram) -> Iterator[str]:
    word = argv[0] if argv else ""
    if "/" in word:
        path = _absolute(word, program.cwd)
        if not os.path.realpath(path).startswith(_SYSTEM) and not is_installed(path):
            yield path


def _python_path(program: WatchedProgram) -> list[str]:
    words = program.env.get("PYTHONPATH", "").split(os.pathsep)
    return [_absolute(word, program.cwd) for word in words if word]


def _own_path() -> list[str]:
    """`sys.path` without the folder of this program and its PYTHONPATH."""
    own = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    return [path for path in sys.path[1:] if path not in own]


def _absolute(path: str, cwd: str | None) -> str:
    return os.path.join(cwd or os.getcwd(), path)
