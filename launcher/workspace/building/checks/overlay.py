"""Interface packages of the workspace that hide an installed package of the same name."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator

from launcher.workspace.building.checks.known import Environment
from launcher.workspace.building.sources import Package
from launcher.workspace.building.sources.source_text import SourceError

_COMMENT = re.compile(r"(^|\s)#.*$", re.MULTILINE)
_SHOWN = 3  # names in a message


def check_overlay(package: Package, environment: Environment) -> Iterator[SourceError]:
    """A warning if interfaces differ from the installed ones, and installed packages use these.

    The libraries of such packages are compiled for the old fields, but get the new messages.
    """
    installed = environment.interfaces(package.name)
    if package.manifest is None or not installed:
        return
    users = [
        name
        for name in sorted(environment.interface_packages() - {package.name})
        if package.name in environment.run_dependencies(name)
    ]
    changed = sorted(name for name in installed if users and _differs(package, environment, name))
    if changed:
        yield package.manifest.source.warning(
            f"{package.name} hides the installed package, which has other fields in "
            f"{_some(changed)}: {_some(users)} would read wrong data",
            package.manifest.name_line,
            at=package.name,
            hint="keep the installed fields, and put others into a package of another name",
        )


def _differs(package: Package, environment: Environment, interface: str) -> bool:
    """Whether a definition such as `msg/Header` is another one, or missing in the workspace."""
    file = f"{interface}.{os.path.dirname(interface)}"
    for prefix in environment.prefixes:
        old = _fields(os.path.join(prefix, "share", package.name, file))
        if old is not None:
            return old != _fields(package.file(file))
    return False


def _fields(path: str) -> list[list[str]] | None:
    """The lines of a definition as words, without comments."""
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read()
    except (OSError, UnicodeDecodeError):
        return None
    return [line.split() for line in _COMMENT.sub("", text).splitlines() if line.strip()]


def _some(names: list[str]) -> str:
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return ", ".join(names[:_SHOWN]) + more
