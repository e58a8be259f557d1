"""Compiled files of a release: for which machine, Python and C library they are."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterable

from launcher.base.errors import LauncherError
from launcher.base.model.record import Record
from launcher.base.program import program
from launcher.hosts.sync.release_tree import TreeEntry
from launcher.hosts.sync.wheels import PythonTarget

_MACHINES = {3: "i686", 40: "armv7l", 62: "x86_64", 183: "aarch64", 243: "riscv64"}
_GLIBC = re.compile(rb"\0GLIBC_2\.(\d+)(?=[\0.])")
_PYTHON = re.compile(r"install/lib/python3\.(\d+)/")


class Native(Record):
    """A compiled file; `glibc` is the minor version that it needs at least."""

    path: str
    machine: str
    glibc: int
    python: int | None


def natives(entries: Iterable[TreeEntry]) -> list[Native]:
    """The ELF files among those; OSError."""
    return [found for entry in entries if (found := _native(entry)) is not None]


def check(found: Iterable[Native], target: PythonTarget) -> None:
    """LauncherError if a host cannot load one of the files."""
    for one in found:
        problem, hint = _problem(one, target)
        if problem:
            name = one.path.removeprefix("install/")
            raise LauncherError(f"{name} cannot be used there: {problem}", hint=hint)


def _problem(one: Native, target: PythonTarget) -> tuple[str, str]:
    build = f"{program()} build"
    version = target.version[1]
    if one.machine != target.machine:
        return (
            f"it was built for {one.machine}, and the host is {target.machine}",
            f"run `{build}` and `{program()} hosts sync` on a machine like the host",
        )
    if one.python is not None and one.python != version:
        return (
            f"it was built for Python 3.{one.python}, and the host's is 3.{version}",
            f"name a Python 3.{one.python} there by `python:` in the hosts file, or run `{build}` "
            f"with Python 3.{version}",
        )
    if target.glibc is not None and one.glibc > target.glibc[1]:
        return (
            f"it needs glibc 2.{one.glibc}, and the host has 2.{target.glibc[1]}",
            f"{build} --all --compiler zig",
        )
    return "", ""


def _native(entry: TreeEntry) -> Native | None:
    if entry.source is None:
        return None
    with open(entry.source, "rb") as file:
        head = file.read(20)
        if head[:4] != b"\x7fELF" or len(head) < 20:
            return None
        content = head + file.read()
    order = "<" if head[5] == 1 else ">"
    number = struct.unpack(f"{order}H", head[18:20])[0]
    python = _PYTHON.match(entry.path)
    return Native(
        path=entry.path,
        machine=_MACHINES.get(number, f"machine {number}"),
        glibc=max((int(minor) for minor in _GLIBC.findall(content)), default=0),
        python=int(python[1]) if python else None,
    )
