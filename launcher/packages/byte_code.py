"""Modules that Python compiles again at every start, since it cannot keep their byte code.

That takes longer than the rest of a start, of the launcher and of each node. pip compiles what it
installs, uv does not, and the container images of Python are without byte code of the standard
library; a module is compiled by the first one who may write beside it (PEP 3147).
"""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Iterator, Mapping
from importlib.util import cache_from_source

from launcher.base.model.record import Record

VARIABLE = "PYTHONDONTWRITEBYTECODE"
STANDARD = "the standard library"
_SITES = ("site-packages", "dist-packages")
_OWN_FOLDER = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
_STANDARD_FOLDER = os.path.dirname(os.__file__)


class Uncached(Record):
    """`names` of packages, or STANDARD; `command` compiles what is in these folders, for good."""

    names: tuple[str, ...]
    folders: tuple[str, ...]
    is_by_variable: bool
    command: str

    def __str__(self) -> str:
        names = ", ".join(self.names)
        why = f"{VARIABLE} is set" if self.is_by_variable else "it may not write beside the modules"
        return f"Python compiles {names} again at every start, since {why}"


def uncached(env: Mapping[str, str]) -> Uncached | None:
    """Of the launcher, rclpy and the standard library, what is compiled at every start with `env`.

    It is that of this process, or has what decides about byte code from there.
    """
    found = dict(_found(env))
    if not found:
        return None
    # What a package imports is compiled anew, too, where both were installed alike.
    above = {os.path.dirname(folder) for folder in found.values()}
    sites = [one for one in above if os.path.basename(one) in _SITES]
    rest = [one for one in found.values() if os.path.dirname(one) not in sites]
    folders = sorted([*sites, *rest])
    may_write = all(os.access(folder, os.W_OK) for folder in folders)
    sudo = () if may_write else ("sudo",)
    return Uncached(
        names=tuple(found),
        folders=tuple(folders),
        is_by_variable=bool(env.get(VARIABLE)),
        command=shlex.join([*sudo, sys.executable, "-m", "compileall", "-qq", *folders]),
    )


def _found(env: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """(name, folder) of each."""
    # What this process has imported was compiled then, if nobody has before; this module just now.
    if _is_lost(__file__):
        yield "launcher", _OWN_FOLDER
    specs = [getattr(module, "__spec__", None) for module in [*sys.modules.values()]]
    origins = filter(None, (getattr(spec, "origin", None) for spec in specs))
    if any(_is_lost(one) for one in origins if one.startswith(f"{_STANDARD_FOLDER}/")):
        yield STANDARD, _STANDARD_FOLDER
    inits = (f"{folder}/rclpy/__init__.py" for folder in sys.path if isinstance(folder, str))
    init = next(filter(os.path.isfile, inits), None)
    if init is not None and _is_lost(init) and not _can_be_cached(init, env):
        yield "rclpy", os.path.dirname(os.path.abspath(init))


def _is_lost(source: str) -> bool:
    is_module = source.endswith(".py") and os.path.isfile(source)
    return is_module and not _is_cached(source)


def _is_cached(source: str) -> bool:
    """Whether Python would use its byte code: of the same time and size, or checked by a hash.

    PEP 552 has the layout.
    """
    try:
        found = os.stat(source)
        with open(cache_from_source(source), "rb") as file:
            head = file.read(16)
    except (OSError, NotImplementedError):
        return False
    numbers = (int(found.st_mtime), found.st_size)
    stamp = b"".join((number & 0xFFFFFFFF).to_bytes(4, "little") for number in numbers)
    return len(head) == 16 and (head[4:8] != bytes(4) or head[8:] == stamp)


def _can_be_cached(source: str, env: Mapping[str, str]) -> bool:
    """Whether the next process that imports it keeps what it compiles."""
    folder = os.path.dirname(cache_from_source(source))
    while not os.path.lexists(folder):
        folder = os.path.dirname(folder)
    return not env.get(VARIABLE) and os.access(folder, os.W_OK)
