"""The extra `build` of this distribution: what building needs."""

from __future__ import annotations

import importlib.util
import re
from importlib import metadata

from launcher.base.errors import LauncherError
from launcher.base.text import several
from launcher.packages.extras import DISTRIBUTION, install_command

_EXTRA = re.compile(r"""extra\s*==\s*['"]build['"]""")


def require() -> None:
    """LauncherError with the command that installs what is missing."""
    lacking = missing()
    if not lacking:
        return
    raise LauncherError(
        f"building needs packages that are not installed: {several(lacking, 3)}",
        hint=f"install them once: {install_command('build')}",
    )


def missing() -> list[str]:
    """The requirements of the extra that are not installed, or in a version that does not fit."""
    try:
        wanted = [one for one in metadata.requires(DISTRIBUTION) or () if _EXTRA.search(one)]
    except metadata.PackageNotFoundError:
        wanted = []
    if not wanted:  # not installed, or by a version without the extra
        return ["colcon-core"] if importlib.util.find_spec("colcon_core") is None else []
    return [name for name in map(_lacking, wanted) if name]


def _lacking(requirement: str) -> str | None:
    text = requirement.partition(";")[0].strip()
    name = re.split(r"[^\w.-]", text, maxsplit=1)[0]
    try:
        version = metadata.version(name)
    except metadata.PackageNotFoundError:
        return name
    bound = text[len(name) :].strip()
    return None if _fits(version, bound) else f"{text} (there is {version})"


def _fits(version: str, bound: str) -> bool:
    if not bound or importlib.util.find_spec("packaging") is None:
        return True
    from packaging.specifiers import SpecifierSet

    return SpecifierSet(bound.strip("()")).contains(version, prereleases=True)
