"""The libraries of a wheel: what they need, where they look for it, and where they run."""

from __future__ import annotations

import io
import logging
import os
import posixpath
import tempfile
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from auditwheel.libc import Libc
from auditwheel.wheel_abi import analyze_wheel_abi
from elftools.elf.dynamic import DynamicSection
from elftools.elf.elffile import ELFFile

from launcher.base.program import program
from launcher.workspace.building.wheel import archive
from launcher.workspace.building.wheel.archive import WheelEntry

_MAGIC = b"\x7fELF"


@dataclass(frozen=True)
class Library:
    """An entry with a library, the name that others need it by, and the libraries that it needs."""

    entry: WheelEntry
    soname: str
    needed: tuple[str, ...]


def is_library(entry: WheelEntry) -> bool:
    """Whether it is a library or a program for the machine."""
    if isinstance(entry.source, bytes):
        return entry.source.startswith(_MAGIC)
    with open(entry.source, "rb") as file:
        return file.read(len(_MAGIC)) == _MAGIC


def read(entry: WheelEntry, folder: str) -> Library:
    """The library without the RUNPATHs that lead out of the prefix into which it is installed.

    `folder` is where pip puts it, relative to the prefix. In a workspace each package has a folder
    for its libraries, which RUNPATH names; those of wheels are in one.
    """
    data = bytearray(entry.read())
    soname, needed = posixpath.basename(entry.name), []
    elf = ELFFile(io.BytesIO(bytes(data)))
    for section in elf.iter_sections():
        if not isinstance(section, DynamicSection):
            continue
        strings: Any = elf.get_section(section["sh_link"])
        for tag in section.iter_tags():
            kind, offset = tag.entry.d_tag, tag.entry.d_val
            if kind == "DT_NEEDED":
                needed.append(strings.get_string(offset))
            elif kind == "DT_SONAME":
                soname = strings.get_string(offset)
            elif kind in ("DT_RUNPATH", "DT_RPATH"):
                old = strings.get_string(offset)
                start, length = strings["sh_offset"] + offset, len(old.encode())
                data[start : start + length] = _inside(old, folder).encode().ljust(length, b"\0")
    return Library(WheelEntry(entry.name, bytes(data), entry.is_executable), soname, tuple(needed))


def _inside(runpath: str, folder: str) -> str:
    kept = []
    for path in runpath.split(":"):
        if path == "$ORIGIN" or path.startswith("$ORIGIN/"):
            target = posixpath.normpath(folder + path.removeprefix("$ORIGIN"))
            if target != ".." and not target.startswith("../"):
                kept.append(path)
    return ":".join(kept)


def platform(libraries: Sequence[Library], required: Collection[str]) -> tuple[str, str]:
    """The platform tag by auditwheel, and a reason if it is not one of manylinux, else "".

    `required` are the libraries of the distributions that the wheel requires.
    """
    logging.getLogger("auditwheel").setLevel(logging.ERROR)
    own = {library.soname for library in libraries}
    own |= {posixpath.basename(library.entry.name) for library in libraries}
    with tempfile.TemporaryDirectory(prefix="launcher-") as folder:
        path = os.path.join(folder, "libraries-0-py3-none-linux_x86_64.whl")
        entries = [WheelEntry(library.entry.name, library.entry.source) for library in libraries]
        entries.append(WheelEntry("libraries-0.dist-info/WHEEL", b"Wheel-Version: 1.0\n"))
        archive.write(path, entries, "libraries-0.dist-info", archive.timestamp(None))
        found = analyze_wheel_abi(
            Libc.detect(),
            None,
            Path(path),
            frozenset({*own, *required}),
            disable_isa_ext_check=False,
            allow_graft=False,
        )
    tag = str(found.overall_policy.name)
    if not tag.startswith("linux"):
        return tag, ""
    foreign = sorted(found.external_refs[found.policies.highest.name].libs)
    if foreign:
        return tag, f"its libraries need {', '.join(foreign)} of this machine"
    if found.machine_policy == found.policies.linux:
        return tag, "it is compiled for the processor of this machine (-march)"
    return tag, (
        "its libraries need a newer glibc or libstdc++ than any tag of manylinux allows; "
        f"{program()} build --compiler zig makes them for glibc 2.28"
    )
