"""Why a program cannot be executed, before it is tried; the system reports only `No such file`.

The faults are certain now. A file may change until it is executed.
"""

from __future__ import annotations

import os
import shlex
import stat
from collections.abc import Iterable, Iterator, Mapping

from launcher.base.text import did_you_mean

_HEAD_BYTES = 256  # BINPRM_BUF_SIZE of the kernel
_LIKENESS = 0.8  # of a name among the thousands in PATH
_LEVELS, _MAX_FOLDERS = 2, 200  # in which a program is searched that is not there
_ELF = b"\x7fELF"
_BOM = b"\xef\xbb\xbf"
# e_machine of ELF files -> name; those that x86-64 executes, too, are 3 and 62.
_MACHINES = {3: "x86", 40: "ARM", 62: "x86-64", 183: "ARM64", 243: "RISC-V"}
_ALSO = {62: (3,), 183: (40,)}
_BINFMT = "/proc/sys/fs/binfmt_misc"


class ProgramFault:
    """What is wrong, and how to repair it."""

    __slots__ = ("hint", "text")

    def __init__(self, text: str, hint: str | None = None) -> None:
        self.text = text
        self.hint = hint

    def __str__(self) -> str:
        return self.text if self.hint is None else f"{self.text}; hint: {self.hint}"


def fault_of(
    program: str, env: Mapping[str, str], cwd: str | None = None, beside: str | None = None
) -> ProgramFault | None:
    """Why a program cannot be executed in a folder and an environment; None if nothing is known.

    `beside` is a folder in which it might be meant to be, that of the launch file.
    """
    if cwd is not None and not os.path.isdir(cwd):
        return ProgramFault(f"the working directory '{cwd}' is no folder")
    if "/" in program:
        path = os.path.join(cwd or "", program)
        return _of_file(path, program, env, cwd) or _absent(path, program, cwd, beside)
    found = [path for path in _in_path(program, env) if os.path.lexists(path)]
    if not found:
        return _not_in_path(program, env, cwd, beside)
    faults = [_of_file(path, path, env, cwd) for path in found]
    return None if None in faults else faults[0]


def _in_path(program: str, env: Mapping[str, str]) -> Iterator[str]:
    return (os.path.join(folder, program) for folder in os.get_exec_path(env))


# ---- a file that is not there


def _absent(path: str, program: str, cwd: str | None, beside: str | None) -> ProgramFault | None:
    if os.path.exists(path):
        return None
    if os.path.lexists(path):
        target = os.readlink(path)
        return ProgramFault(f"'{program}' is a link to '{target}', which does not exist")
    text = f"there is no '{program}'"
    if os.path.isabs(program):
        return ProgramFault(text, _near(path))
    where = "in the working directory" if cwd is None else f"in '{cwd}'"
    return ProgramFault(f"{text} {where}", _elsewhere(program, cwd, beside) or _near(path))


def _elsewhere(program: str, cwd: str | None, beside: str | None) -> str | None:
    """Where a program is that is not where it is looked for."""
    if beside is not None and os.path.isfile(os.path.join(beside, program)):
        name = os.path.normpath(program)
        written = f"os.path.join(os.path.dirname(__file__), '{name}')"
        return f"it is beside the launch file: write {written}, in XML and YAML $(dirname)/{name}"
    folders = [cwd or os.curdir, *([beside, os.path.dirname(beside)] if beside else [])]
    found = next(_below(folders, os.path.basename(program)), None)
    return found and f"there is one in another folder: '{os.path.normpath(found)}'"


def _below(folders: Iterable[str], name: str) -> Iterator[str]:
    """Files of this name two levels below the folders, of which some hundred are looked into."""
    looked_at = 0
    for top in folders:
        depth = top.rstrip("/").count("/") + _LEVELS
        for folder, below, files in os.walk(top):
            looked_at += 1
            if name in files:
                yield os.path.join(folder, name)
            is_deep = folder.count("/") >= depth or looked_at > _MAX_FOLDERS
            below[:] = [] if is_deep else sorted(one for one in below if one[0] != ".")


def _near(path: str) -> str | None:
    folder, name = os.path.split(path)
    try:
        return did_you_mean(name, os.listdir(folder or os.curdir))
    except OSError:
        return None


def _not_in_path(
    program: str, env: Mapping[str, str], cwd: str | None, beside: str | None
) -> ProgramFault:
    text = f"there is no program '{program}' in PATH"
    if os.path.isfile(os.path.join(cwd or "", program)):
        return ProgramFault(text, f"write './{program}' for the file in the working directory")
    hint = _elsewhere(program, cwd, beside)
    if hint is None:
        import difflib  # only mistakes need it

        known: set[str] = set()
        for folder in os.get_exec_path(env):
            try:
                known.update(os.listdir(folder))
            except OSError:
                continue
        near = difflib.get_close_matches(program, known, 1, _LIKENESS)
        hint = f"did you mean '{near[0]}'?" if near else None
    return ProgramFault(text, hint)


# ---- a file


def _of_file(path: str, shown: str, env: Mapping[str, str], cwd: str | None) -> ProgramFault | None:
    try:
        mode = os.stat(path).st_mode
        if stat.S_ISDIR(mode):
            return ProgramFault(f"'{shown}' is a folder, not a program")
        if not stat.S_ISREG(mode):
            return None
        if not os.access(path, os.X_OK):
            return _no_permission(path, shown, mode)
        head = _head(path)
    except OSError:
        return None
    if head.startswith(_ELF):
        return _of_machine(head, shown)
    if head.startswith(b"#!"):
        return _of_interpreter(head, path, shown, env, cwd)
    return _no_format(head, shown)


def _head(path: str) -> bytes:
    with open(path, "rb") as file:
        return file.read(_HEAD_BYTES)


def _no_permission(path: str, shown: str, mode: int) -> ProgramFault:
    """Raises OSError."""
    if mode & 0o111 and os.statvfs(path).f_flag & os.ST_NOEXEC:
        return ProgramFault(f"'{shown}' is on a file system without programs (noexec)")
    hint = f"chmod +x {shlex.quote(path)}"
    if not os.access(path, os.R_OK) or _head(path).startswith((_ELF, b"#!")):
        return ProgramFault(f"'{shown}' is not executable", hint)
    hint += f", and write '{_first_line(shown)}' into its first line"
    return ProgramFault(f"'{shown}' is not executable", hint)


def _of_machine(head: bytes, shown: str) -> ProgramFault | None:
    machine, own = _machine(head), _own_machine()
    is_known = machine in _MACHINES and own in _MACHINES
    if not is_known or machine == own or machine in _ALSO.get(own, ()) or _handlers():
        return None
    return ProgramFault(f"'{shown}' is for {_MACHINES[machine]}; this machine is {_MACHINES[own]}")


def _machine(head: bytes) -> int:
    return int.from_bytes(head[18:20], "big" if head[5:6] == b"\2" else "little")


def _own_machine() -> int:
    with open("/proc/self/exe", "rb") as file:
        return _machine(file.read(20))


def _handlers() -> bool:
    """Whether the kernel has handlers for further formats."""
    try:
        return any(name not in ("register", "status") for name in os.listdir(_BINFMT))
    except OSError:
        return False


def _of_interpreter(
    head: bytes, path: str, shown: str, env: Mapping[str, str], cwd: str | None
) -> ProgramFault | None:
    line = os.fsdecode(head[2:].partition(b"\n")[0])
    if line.endswith("\r"):
        hint = f"sed -i 's/\\r$//' {shlex.quote(path)}"
        return ProgramFault(f"the '#!' line of '{shown}' ends with a carriage return (CRLF)", hint)
    words = line.split(None, 1)
    if not words:
        return ProgramFault(f"the '#!' line of '{shown}' names no interpreter")
    if os.path.basename(words[0]) == "env" and len(words) > 1:
        name = words[1].split()[0]
        is_plain = not name.startswith("-") and "=" not in name
        if is_plain and "/" not in name and not any(map(os.path.exists, _in_path(name, env))):
            text = f"the '#!' line of '{shown}' asks for '{name}', which is not in PATH"
            return ProgramFault(text)
    interpreter = os.path.join(cwd or "", words[0])
    if not os.path.exists(interpreter):
        return ProgramFault(f"the '#!' line of '{shown}' names '{words[0]}', which does not exist")
    if not os.access(interpreter, os.X_OK) or os.path.isdir(interpreter):
        text = f"the '#!' line of '{shown}' names '{words[0]}', which is not executable"
        return ProgramFault(text)
    return None


def _no_format(head: bytes, shown: str) -> ProgramFault | None:
    if not head:
        return ProgramFault(f"'{shown}' is empty")
    if head.startswith(_BOM + b"#!"):
        hint = "save it as UTF-8 without one"
        return ProgramFault(f"'{shown}' has a byte order mark in front of its '#!'", hint)
    if b"\0" in head:
        return None if _handlers() else ProgramFault(f"'{shown}' is no program of this machine")
    hint = f"write '{_first_line(shown)}' into its first line"
    return ProgramFault(f"'{shown}' does not begin with a '#!' line", hint)


def _first_line(path: str) -> str:
    return "#!/usr/bin/env python3" if path.endswith(".py") else "#!/bin/sh"
