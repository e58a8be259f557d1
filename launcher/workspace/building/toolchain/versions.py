"""Which versions of the tools and wheels a build uses, as one text that is compared."""

from __future__ import annotations

import contextlib
import glob
import hashlib
import os
import sys
from collections.abc import Iterable, Iterator

from launcher.packages.extras import DISTRIBUTION

# What generates, compiles or installs; other distributions may come and go.
_COUNTING = (
    *("ros_", "rosidl", "ament", DISTRIBUTION.replace("-", "_")),
    *("cmake-", "ninja-", "numpy-", "lark-", "empy-", "setuptools-", "colcon_"),
)


def fingerprint() -> str:
    """`3.11.2 /path/of/python SHA`: the Python, the distributions that count, our CMake files."""
    version = ".".join(map(str, sys.version_info[:3]))
    names = sorted({name for folder in sys.path for name in _distributions(folder)})
    digest = hashlib.sha256("\n".join([*names, *_hooks()]).encode()).hexdigest()[:16]
    return f"{version} {sys.prefix} {digest}"


def interfaces(prefixes: Iterable[str]) -> str:
    """A digest of the messages in other workspaces, for which C code is compiled; empty without.

    Those of the wheels do not count: their versions do.
    """
    digest = hashlib.sha256()
    paths = [
        path
        for prefix in prefixes
        if prefix != sys.prefix
        for path in sorted(glob.glob(f"{glob.escape(prefix)}/share/*/*/*.idl"))
    ]
    for path in paths:
        with contextlib.suppress(OSError), open(path, "rb") as file:
            digest.update(path.encode(errors="surrogateescape") + b"\0" + file.read())
    return digest.hexdigest()[:16] if paths else ""


def _hooks() -> Iterator[str]:
    folder = os.path.dirname(os.path.abspath(__file__))
    for name in sorted(os.listdir(folder)):
        if name.endswith(".cmake"):
            with open(os.path.join(folder, name), encoding="utf-8") as file:
                yield file.read()


def _distributions(folder: str) -> list[str]:
    try:
        names = os.listdir(folder or os.curdir)
    except OSError:
        return []
    return [
        name.removesuffix(".dist-info").lower()
        for name in names
        if name.endswith(".dist-info") and name.lower().startswith(_COUNTING)
    ]
