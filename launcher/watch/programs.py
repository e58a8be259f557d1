"""Which files a process has loaded, found without running it."""

from __future__ import annotations

import functools
import importlib
import os
import sys
from collections.abc import Iterator, Mapping

from launcher.model.record import Record, replace
from launcher.packages.imports import imports_of, is_installed
from launcher.packages.python_program import PythonProgram, program_of

_SYSTEM = ("/usr/", "/bin/", "/sbin/", "/lib", "/opt/ros/")  # changes there are no edits


class Program(Record):
    """A command as it was started; `parameters` are the parameter files of the user.

    `members` are the commands of the nodes that it runs itself, instead of its own.
    """

    argv: tuple[str, ...]
    env: Mapping[str, str]
    cwd: str | None = None
    parameters: tuple[str, ...] = ()
    members: tuple[tuple[str, ...], ...] = ()

    @property
    def parameter_files(self) -> list[str]:
        return [_absolute(path, self.cwd) for path in self.parameters]


def files_of(program: Program) -> list[str]:
    """The absolute paths of its own source files and parameter files, the program first."""
    commands = program.members or (program.argv,)
    sources = [path for argv in commands for path in _sources(replace(program, argv=argv))]
    paths = [*sources, *program.parameter_files]
    return list(dict.fromkeys(os.path.normpath(path) for path in paths))


def _sources(program: Program) -> list[str]:
    found = _python(program)
    if found is None:
        return list(_executable(program))
    first, script, module = found
    path = (first, *_python_path(program), *_own_path())
    return [_absolute(file, program.cwd) for file in _imports(script, module, path)]


@functools.cache
def _imports(script: str, module: str, path: tuple[str, ...]) -> list[str]:
    return imports_of(script=script, module=module, path=path).files


def forget_imports() -> None:
    """Files have changed; until then processes of one program share what was found."""
    _imports.cache_clear()
    importlib.invalidate_caches()


def _python(program: Program) -> tuple[str, str, str] | None:
    """(first folder of its path, script, module) of the Python program, also behind a prefix."""
    cwd = program.cwd or os.getcwd()
    for start in range(len(program.argv)):
        if program.argv[start] == "--ros-args":
            break
        found = program_of(program.argv[start:], program.env, program.cwd)
        if isinstance(found, PythonProgram) and found.module:
            return cwd, "", found.module
        if isinstance(found, PythonProgram):
            script = _absolute(found.script, cwd)
            return os.path.dirname(os.path.realpath(script)), script, ""
    for word in program.argv:  # of another interpreter, or with options of it
        path = _absolute(word, cwd)
        if word.endswith(".py") and os.path.isfile(path):
            return os.path.dirname(os.path.realpath(path)), path, ""
    return None


def _executable(program: Program) -> Iterator[str]:
    word = program.argv[0] if program.argv else ""
    if "/" in word:
        path = _absolute(word, program.cwd)
        if not os.path.realpath(path).startswith(_SYSTEM) and not is_installed(path):
            yield path


def _python_path(program: Program) -> list[str]:
    words = program.env.get("PYTHONPATH", "").split(os.pathsep)
    return [_absolute(word, program.cwd) for word in words if word]


def _own_path() -> list[str]:
    """`sys.path` without the folder of this program and its PYTHONPATH."""
    own = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    return [path for path in sys.path[1:] if path not in own]


def _absolute(path: str, cwd: str | None) -> str:
    return os.path.join(cwd or os.getcwd(), path)
