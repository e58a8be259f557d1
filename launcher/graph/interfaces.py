"""Interfaces: which message, service and action types are installed, and their Python classes."""

from __future__ import annotations

import difflib
import importlib
import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from launcher.graph.errors import VerbError

KINDS = ("msg", "srv", "action")
_INDEX = Path("share/ament_index/resource_index/rosidl_interfaces")


def prefixes() -> list[Path]:
    """Where packages are installed, the first one wins."""
    words = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [Path(word) for word in dict.fromkeys([*filter(None, words), sys.prefix])]


def interface_packages() -> dict[str, Path]:
    """Package with interfaces -> its prefix, sorted."""
    found: dict[str, Path] = {}
    for prefix in prefixes():
        if (prefix / _INDEX).is_dir():
            for entry in (prefix / _INDEX).iterdir():
                found.setdefault(entry.name, prefix)
    return dict(sorted(found.items()))


def interfaces_of(package: str, kinds: Iterable[str] = KINDS) -> list[str]:
    """Full names of a package's interfaces, sorted; empty if there is no such package."""
    prefix = interface_packages().get(package)
    if prefix is None:
        return []
    lines = (prefix / _INDEX / package).read_text(encoding="utf-8").splitlines()
    names = {line.rsplit(".", 1)[0] for line in lines if line.endswith(".idl")}
    return sorted(f"{package}/{name}" for name in names if name.split("/")[0] in kinds)


def all_interfaces(kinds: Iterable[str] = KINDS) -> list[str]:
    """Full names of all installed interfaces, sorted."""
    kinds = tuple(kinds)
    return [name for package in interface_packages() for name in interfaces_of(package, kinds)]


def load(type_name: str, kind: str, complaint: str) -> Any:
    """The class of `pkg/msg/Name` (or `pkg/Name`); VerbError with the complaint and a near miss."""
    package, _, rest = type_name.partition("/")
    name = rest.removeprefix(f"{kind}/")
    if package.isidentifier() and name.isidentifier():
        try:
            return getattr(importlib.import_module(f"{package}.{kind}"), name)
        except (ModuleNotFoundError, AttributeError):
            pass  # the near miss is looked for below
    raise VerbError(complaint, hint=_near(type_name, package, name, kind))


def load_message(type_name: str) -> Any:
    """The class of a message type; VerbError as ros2cli words it."""
    return load(type_name, "msg", "The passed message type is invalid")


def _near(type_name: str, package: str, name: str, kind: str) -> str | None:
    known = all_interfaces([kind])
    tails = {n.rsplit("/", 1)[1]: n for n in known if n.startswith(f"{package}/")}
    if near := difflib.get_close_matches(name, tails, n=1):
        return f"did you mean {near[0]}? ({tails[near[0]]})"
    whole = difflib.get_close_matches(f"{package}/{kind}/{name}", known, n=1)
    return f"did you mean {whole[0]}?" if whole else f"no such type is installed: {type_name}"
