"""The extra `build` of this distribution, and that of the wheels of ROS 2: what building needs."""

from __future__ import annotations

import importlib.util
import re
from importlib import metadata

from launcher.base.errors import UsageError
from launcher.base.text import several
from launcher.packages import distribution
from launcher.packages.absent_ros import ros_hint
from launcher.packages.extras import DISTRIBUTION, install_command

_EXTRA = re.compile(r"""extra\s*==\s*['"](\w+)['"]""")


def require() -> None:
    """UsageError with the command that installs what is missing."""
    lacking = missing()
    if not lacking:
        return
    once = f"install them once: {install_command(','.join(extras()))}"
    raise UsageError(
        f"building needs packages that are not installed: {several(lacking, 3)}",
        hint=ros_hint("build") if distribution.find() is None else once,
    )


def extras() -> tuple[str, ...]:
    """An installed ROS 2 has the CMake files and generators that are in the extra of its wheels."""
    found = distribution.find()
    is_wheels = found is not None and found.is_wheels and found.name in distribution.EXTRAS
    return ("build", str(found.name)) if found is not None and is_wheels else ("build",)


def missing() -> list[str]:
    """The requirements of the extras that are not installed, or in a version that does not fit."""
    try:
        needed = extras()
        wanted = [
            one
            for one in metadata.requires(DISTRIBUTION) or ()
            if (extra := _EXTRA.search(one)) and extra[1] in needed
        ]
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
    bound = re.sub(r"^\[.*?\]", "", text[len(name) :].strip())  # `name[extra]<4`
    return None if _fits(version, bound) else f"{text} (there is {version})"


def _fits(version: str, bound: str) -> bool:
    if not bound or importlib.util.find_spec("packaging") is None:
        return True
    from packaging.specifiers import SpecifierSet

    return SpecifierSet(bound.strip("()")).contains(version, prereleases=True)
