"""Which commands are Python programs of the interpreter that runs the launcher."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence

_SHEBANG_BYTES = 256  # BINPRM_BUF_SIZE of the kernel
_ZIP_TAIL = 22  # bytes of the record at the end of a zip file, most of them 0


class PythonProgram:
    """A program of this interpreter: either `script`, a path, or `module`, as in `python -m`.

    `interpreter` is the path with which Python is executed, `executed` the file that is: that or
    the script itself. `words` are its arguments. `orig_argv` is what the interpreter gets.
    """

    __slots__ = ("executed", "interpreter", "module", "orig_argv", "script", "words")

    def __init__(
        self,
        interpreter: str,
        *,
        executed: str,
        words: Sequence[str],
        orig_argv: Sequence[str],
        script: str = "",
        module: str = "",
    ) -> None:
        self.interpreter = interpreter
        self.executed = executed
        self.words = tuple(words)
        self.orig_argv = tuple(orig_argv)
        self.script = script
        self.module = module


def program_of(
    argv: Sequence[str], env: Mapping[str, str], cwd: str | None = None
) -> PythonProgram | str:
    """What a command runs, or in a few words why it is no such program.

    `env` and `cwd` (None: ours) are those of the process. A prefix, another interpreter, and
    options of the interpreter that change how it runs are such reasons.
    """
    if not argv:
        return "it has no command"
    path = _which(argv[0], env, cwd)
    if path is None:
        return f"'{argv[0]}' was not found"
    if _is_python_name(path):
        return _by_interpreter(path, argv, cwd)
    line = _first_line(_absolute(path, cwd))
    if not line.startswith(b"#!"):
        return f"'{os.path.basename(path)}' is not a Python script"
    found = _shebang_interpreter(os.fsdecode(line[2:]).split(None, 1), env, cwd)
    if not isinstance(found, tuple):
        return found
    interpreter, argv0, executed = found
    orig_argv = (argv0, path, *argv[1:])
    program = PythonProgram(
        interpreter, executed=executed or path, words=argv[1:], orig_argv=orig_argv, script=path
    )
    return _checked(program, cwd)


def interpreter_of(
    argv: Sequence[str], env: Mapping[str, str], cwd: str | None = None
) -> str | None:
    """The path of the Python that runs a command, ours or another; None if it is not known."""
    path = _which(argv[0], env, cwd) if argv else None
    if path is None or _is_python_name(path):
        return path
    line = _first_line(_absolute(path, cwd))
    if not line.startswith(b"#!"):
        return None
    found = _shebang_interpreter(os.fsdecode(line[2:]).split(None, 1), env, cwd)
    is_python = isinstance(found, tuple) and _is_python_name(found[0])
    return found[0] if is_python else None


def _which(program: str, env: Mapping[str, str], cwd: str | None) -> str | None:
    if "/" in program:
        return program if os.path.isfile(_absolute(program, cwd)) else None
    paths = (os.path.join(folder, program) for folder in os.get_exec_path(env))
    return next((path for path in paths if os.path.isfile(_absolute(path, cwd))), None)


def _absolute(path: str, cwd: str | None) -> str:
    return path if cwd is None else os.path.join(cwd, path)


def _is_python_name(path: str) -> bool:
    name = os.path.basename(path)
    return name.startswith("python") and not name[6:].strip(".0123456789")


def _first_line(path: str) -> bytes:
    try:
        fd = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    except OSError:
        return b""
    try:
        return os.read(fd, _SHEBANG_BYTES).partition(b"\n")[0]
    except OSError:
        return b""
    finally:
        os.close(fd)


def _shebang_interpreter(
    words: Sequence[str], env: Mapping[str, str], cwd: str | None
) -> tuple[str, str, str] | str:
    """(interpreter, its argv[0], the file that is executed if not the script) of a `#!` line."""
    if not words:
        return "its '#!' line is empty"
    path, rest = words[0], words[1].strip() if len(words) > 1 else ""
    if os.path.basename(path) == "env" and rest and not rest.startswith("-"):
        found = None if " " in rest else _which(rest, env, cwd)
        if found is None:
            return f"its '#!' line has '{rest}'"
        return (found, rest, found)
    if rest:
        return f"its '#!' line has '{rest}'"
    if not _is_python_name(path):
        return f"its '#!' line has '{path}'"
    return (path, path, "")


def _by_interpreter(path: str, argv: Sequence[str], cwd: str | None) -> PythonProgram | str:
    """`python file.py ...` and `python -m module ...`."""
    rest = list(argv[1:])
    while rest and rest[0].startswith("-"):
        option = rest.pop(0)
        if option == "-m" and rest:
            name, *words = rest
            program = PythonProgram(path, executed=path, words=words, orig_argv=argv, module=name)
            return _checked(program, cwd)
        return f"it has the option '{_shown(option)}' of the interpreter"
    if not rest:
        return "it reads its program from standard input"
    script, *words = rest
    program = PythonProgram(path, executed=path, words=words, orig_argv=argv, script=script)
    return _checked(program, cwd)


def _shown(option: str) -> str:
    return option[:2] if option[1:2] in ("c", "m", "W", "X") else option


def _checked(program: PythonProgram, cwd: str | None) -> PythonProgram | str:
    """The program, if its interpreter is ours and its script a file."""
    if not is_ours(_absolute(program.interpreter, cwd)):
        return f"'{program.interpreter}' is another interpreter"
    if program.script:
        return _reason_of(program.script, _absolute(program.script, cwd)) or program
    return program


def _reason_of(script: str, path: str) -> str:
    """Why a script is not a text; empty if it is."""
    try:
        with open(path, "rb") as file:
            head = file.read(_SHEBANG_BYTES)
            file.seek(max(0, os.path.getsize(path) - _ZIP_TAIL))
            tail = file.read()
    except OSError as error:
        return f"'{script}' cannot be read: {error.strerror}"
    return f"'{script}' is not a text" if b"\0" in head + tail else ""


def is_ours(path: str) -> bool:
    """Whether this path executes our interpreter, with the same packages.

    The same file in another folder may be that of another virtual environment.
    """
    here, there = os.path.split(sys.executable), os.path.split(os.path.abspath(path))
    if os.path.realpath(here[0]) != os.path.realpath(there[0]):
        return False
    return os.path.realpath(sys.executable) == os.path.realpath(path)
