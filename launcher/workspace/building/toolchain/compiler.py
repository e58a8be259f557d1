"""The C and C++ compiler of a build: the system's, or the wheel ziglang."""

from __future__ import annotations

import importlib.util
import os
import shlex
import shutil
import stat
import subprocess
import sysconfig
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass

from launcher.base.errors import LauncherError, UsageError

# manylinux_2_28: what is compiled on any machine runs with glibc 2.28 and newer.
_ZIG_TARGET = "x86_64-linux-gnu.2.28"
# For each mode zig compiles its C++ library anew: CMake's own tests are to use that of packages.
_ZIG_MODE = "-O2 -s"  # -g0 does not keep debug information out of that library
_ZIG_TOOLS = {
    "cc": f"cc -target {_ZIG_TARGET} {_ZIG_MODE}",
    "c++": f"c++ -target {_ZIG_TARGET} {_ZIG_MODE}",
    "ar": "ar",
    "ranlib": "ranlib",
}
_PAIRS = (("gcc", "g++"), ("clang", "clang++"), ("icx", "icpx"), ("cc", "c++"))
_C, _CXX = "c", "cpp"
_PROGRAMS = {
    _C: '#include <stdio.h>\n#include <stdlib.h>\nint answer(void) { return puts(""); }\n',
    _CXX: '#include <string>\nint answer() { return std::string("a").size(); }\n',
}


@dataclass(frozen=True)
class Compiler:
    """A pair of compilers, `cc` and `cxx` as in the variables CC and CXX: quoted, with arguments.

    `tools` are further definitions for CMake, `cache` is the folder of zig's cache. `identity`
    changes whenever the compiler does.
    """

    name: str
    cc: str
    cxx: str
    tools: tuple[str, ...] = ()
    cache: str = ""

    @property
    def is_zig(self) -> bool:
        return self.name == "zig"

    @property
    def cmake_args(self) -> list[str]:
        args = list(self.tools)
        for variable, command in (("C", self.cc), ("CXX", self.cxx)):
            words = shlex.split(command)
            if len(words) == 1:  # CMake reads one with arguments from the environment
                args.append(f"-DCMAKE_{variable}_COMPILER={words[0]}")
        return args

    @property
    def variables(self) -> dict[str, str]:
        cache = {"ZIG_GLOBAL_CACHE_DIR": self.cache} if self.cache else {}
        return {"CC": self.cc, "CXX": self.cxx, **cache}

    @property
    def identity(self) -> list[object]:
        commands = [self.cc, self.cxx]
        if self.is_zig:  # the two are scripts that call it
            commands.append(shlex.quote(_zig_program() or ""))
        return [self.name, *map(_stamp, commands), *self.tools]


def choose(wanted: str, environ: Mapping[str, str], tools: str) -> Compiler:
    """The compiler `wanted`: "auto", "system", "zig", or the name or path of a C compiler.

    With "auto" it is that of CC and CXX, else the system's if it works, else ziglang. Scripts that
    call ziglang are written into the folder `tools`. LauncherError if there is none.
    """
    if wanted == "zig":
        return _zig(tools, environ)
    if wanted not in ("auto", "system"):
        return _named(wanted, environ)
    if environ.get("CC") or environ.get("CXX"):
        return _of_variables(environ)
    found, problem = _system(environ)
    if found is not None:
        return found
    if wanted == "auto" and _zig_program() is not None:
        return _zig(tools, environ)
    raise LauncherError(
        f"no compiler: {problem}",
        hint="install one (sudo apt-get install g++), or build with --compiler zig",
    )


def _system(environ: Mapping[str, str]) -> tuple[Compiler | None, str]:
    """The first pair that compiles, or why there is none."""
    problem = "neither gcc nor clang is installed"
    for c_name, cxx_name in _PAIRS:
        cc, cxx = (shutil.which(one, path=environ.get("PATH")) for one in (c_name, cxx_name))
        if cc is None or cxx is None:
            if cc is not None:
                problem = f"{cc} is there, but no {cxx_name}"
            continue
        cc, cxx = shlex.quote(cc), shlex.quote(cxx)
        for language, command in ((_C, cc), (_CXX, cxx)):
            failure = _failure(command, language, environ)
            if failure is not None:
                problem = f"{command} {failure}"
                break
        else:
            return Compiler(c_name, cc, cxx), ""
    return None, problem


def _of_variables(environ: Mapping[str, str]) -> Compiler:
    cc, cxx = environ.get("CC", ""), environ.get("CXX", "")
    for name, command in (("CC", cc), ("CXX", cxx)):
        try:
            shlex.split(command)
        except ValueError as error:
            raise LauncherError(
                f"{name}={command}: {error}", hint="quote it as in a shell"
            ) from None
    cc, cxx = _from_anywhere(cc), _from_anywhere(cxx)
    cc = cc or _other(cxx, to_cxx=False)
    cxx = cxx or _other(cc, to_cxx=True)
    for name, other, language, command in (("CC", "CXX", _C, cc), ("CXX", "CC", _CXX, cxx)):
        failure = _failure(command, language, environ)
        if failure is None:
            continue
        if environ.get(name):
            raise LauncherError(
                f"{name}={environ[name]} {failure}", hint=f"correct {name}, or unset it"
            )
        raise LauncherError(
            f"{command} {failure}",
            hint=f"set {name} to the compiler that belongs to that of {other}",
        )
    return Compiler(os.path.basename(shlex.split(cc)[0]), cc, cxx)


def _named(wanted: str, environ: Mapping[str, str]) -> Compiler:
    cc = shutil.which(wanted, path=environ.get("PATH"))
    if cc is None:
        problem = f"there is no program '{wanted}'"
        if os.path.dirname(wanted) and os.path.isdir(wanted):
            problem = f"'{wanted}' is a folder"
        elif os.path.dirname(wanted) and os.path.exists(wanted):
            problem = f"'{wanted}' is not executable"
        raise UsageError(
            f"--compiler: {problem}",
            hint="auto, system, zig, or the name or path of a C compiler, such as clang",
        )
    name = os.path.basename(cc)
    cc = _from_anywhere(shlex.quote(cc))
    failure = _failure(cc, _C, environ)
    if failure is not None:
        raise LauncherError(f"{cc} {failure}", hint="--compiler names a C compiler, such as clang")
    cxx = _other(cc, to_cxx=True)
    failure = _failure(cxx, _CXX, environ)
    if failure is not None:
        hint = (
            f"--compiler {wanted} needs {cxx} as well; "
            f"for another one set CC={wanted} and CXX, without --compiler"
        )
        if cxx == cc:
            hint = f"the C++ compiler of {wanted} is not known: set CC and CXX, without --compiler"
        raise LauncherError(f"{cxx} {failure}", hint=hint)
    return Compiler(name, cc, cxx)


def _from_anywhere(command: str) -> str:
    """The command with an absolute path in place of one that starts at the working directory."""
    program, *arguments = shlex.split(command) or [""]
    if not os.path.dirname(program) or os.path.isabs(program):
        return command
    return shlex.join([os.path.abspath(program), *arguments])


def _other(compiler: str, *, to_cxx: bool) -> str:
    """`g++-12` for `gcc-12`, and the reverse; the compiler itself if its name is unknown."""
    words = shlex.split(compiler)
    folder, name = os.path.split(words[0] if words else "")
    for c_name, cxx_name in _PAIRS:
        old, new = (c_name, cxx_name) if to_cxx else (cxx_name, c_name)
        if old in name and (to_cxx or "+" in name):
            return shlex.join([os.path.join(folder, name.replace(old, new)), *words[1:]])
    return compiler


def _failure(compiler: str, language: str, environ: Mapping[str, str]) -> str | None:
    """Why a compiler cannot compile and link a library; None if it can."""
    with tempfile.TemporaryDirectory(prefix="launcher-") as folder:
        source = os.path.join(folder, f"try.{language}")
        with open(source, "w", encoding="ascii") as file:
            file.write(_PROGRAMS[language])
        words = [*shlex.split(compiler), "-shared", "-fPIC", source, "-o", f"{source}.so"]
        try:
            done = subprocess.run(
                words, env=dict(environ), capture_output=True, check=False, cwd=folder
            )
        except OSError as error:
            return f"cannot be started: {error.strerror}"
    if done.returncode == 0:
        return None
    said = done.stderr.decode(errors="replace").strip().splitlines()
    first = next((line for line in said if "error" in line), "")
    detail = first.rpartition("error:")[2].strip() or f"exit code {done.returncode}"
    return f"does not compile a small program: {detail}"


# ---- zig


def _zig_program() -> str | None:
    spec = importlib.util.find_spec("ziglang")
    for folder in (spec and spec.submodule_search_locations) or ():
        program = os.path.join(folder, "zig")
        if os.path.isfile(program):
            return program
    return None


def _zig(folder: str, environ: Mapping[str, str]) -> Compiler:
    """ziglang as a pair of compilers: scripts, since CMake needs one program for each tool."""
    program = _zig_program()
    if program is None:
        raise LauncherError(
            "the compiler ziglang is not installed", hint="python -m pip install ziglang"
        )
    os.makedirs(folder, exist_ok=True)
    paths = {name: os.path.join(folder, name) for name in _ZIG_TOOLS}
    includes = _python_configuration(folder)
    for name, words in _ZIG_TOOLS.items():
        words += includes if name in ("cc", "c++") else ""
        _write_script(paths[name], f'#!/bin/sh\nexec {shlex.quote(program)} {words} "$@"\n')
    archiver = (f"-DCMAKE_AR={paths['ar']}", f"-DCMAKE_RANLIB={paths['ranlib']}")
    commands = shlex.quote(paths["cc"]), shlex.quote(paths["c++"])
    return Compiler("zig", *commands, archiver, _zig_cache(program, environ))


def _zig_cache(program: str, environ: Mapping[str, str]) -> str:
    """The folder of zig's cache: another for each installed ziglang.

    zig identifies its files by inode and time stamp. In one cache those of two environments would
    replace each other, and every change of the environment would compile the C++ library again.
    """
    status = os.stat(program)
    return f"{zig_caches(environ)}{status.st_ino:x}-{status.st_mtime_ns:x}"


def zig_caches(environ: Mapping[str, str]) -> str:
    """What the paths of our caches of zig begin with."""
    home = environ.get("HOME") or os.path.expanduser("~")
    base = environ.get("XDG_CACHE_HOME") or os.path.join(home, ".cache")
    folder = environ.get("ZIG_GLOBAL_CACHE_DIR") or os.path.join(base, "zig")
    return os.path.join(folder, "launcher-")


def _python_configuration(folder: str) -> str:
    """An argument with which Debian's Python.h finds what it includes.

    That is <x86_64-linux-gnu/python3.X/pyconfig.h>, in /usr/include, which ziglang does not search.
    The argument is a folder with a link to it: other files of /usr/include do not fit the
    libraries of ziglang.
    """
    headers = sysconfig.get_path("include")
    name = os.path.join(sysconfig.get_config_var("MULTIARCH") or "", os.path.basename(headers))
    there = os.path.join(os.path.dirname(headers), name)
    if there == headers or not os.path.isfile(os.path.join(there, "pyconfig.h")):
        return ""
    include = os.path.join(folder, "include")
    link = os.path.join(include, name)
    os.makedirs(os.path.dirname(link), exist_ok=True)
    if os.path.realpath(link) != os.path.realpath(there):
        if os.path.islink(link):
            os.unlink(link)
        os.symlink(there, link)
    return f" -idirafter {shlex.quote(include)}"


def _write_script(path: str, text: str) -> None:
    """Write it unless it is there already: its time stamp is part of the compiler's identity."""
    try:
        with open(path, encoding="utf-8") as file:
            if file.read() == text and os.access(path, os.X_OK):
                return
    except OSError:
        pass
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    os.chmod(path, stat.S_IRWXU | stat.S_IRGRP | stat.S_IXGRP | stat.S_IROTH | stat.S_IXOTH)


def zig_library_is_cached(cache: str) -> bool:
    """Whether ziglang has compiled its C++ library before, which takes a minute and a half."""
    try:
        with os.scandir(os.path.join(cache, "o")) as entries:
            return any(os.path.exists(os.path.join(one.path, "libc++.a")) for one in entries)
    except OSError:
        return False


def _stamp(command: str) -> list[object]:
    """The program of a command, with what changes when it is replaced."""
    program = shlex.split(command)[0]
    path = shutil.which(program) or program
    try:
        status = os.stat(path)
    except OSError:
        return [command]
    return [command, status.st_mtime_ns, status.st_size]
