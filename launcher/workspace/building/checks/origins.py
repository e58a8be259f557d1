"""Packages that are neither in the workspace nor in the environment: where to get them."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable

from launcher.base.text import did_you_mean
from launcher.packages import absent_ros
from launcher.packages.package_origins import (
    clone_commands,
    debian,
    has_wheel,
    is_cpp,
    is_of_launcher,
    needs_ros,
    wheel,
)

# Keys of rosdep for packages of the operating system, and names that no package has.
_SYSTEM = re.compile(r".*-.*|lib\w*|python3?_?\w*|ament_python|eigen|boost|opencv\d?|numpy|pytest")
_LAUNCH = re.compile(r"launch(_\w+)?|ros2launch|ros2cli|ament_\w+")


def is_of_system(name: str) -> bool:
    """Whether a dependency in package.xml means a package of the operating system."""
    return _SYSTEM.fullmatch(name) is not None


def is_of_ros(name: str, known: Iterable[str]) -> bool:
    """Whether the name, which is not known, is certainly meant as one of ROS 2."""
    is_known = is_cpp(name) or needs_ros(name) or has_wheel(name) or bool(clone_commands(name))
    return is_known or _is_near(name, known)


def is_misspelt(name: str, known: Iterable[str]) -> bool:
    """Whether a name that is not needed for building is certainly a wrong one."""
    is_known = is_of_ros(name, ()) or _LAUNCH.fullmatch(name) is not None
    return not is_known and _is_near(name, known)


def _is_near(name: str, known: Iterable[str]) -> bool:
    return bool(difflib.get_close_matches(name, [*known], n=1, cutoff=0.85))


def missing(name: str, known: Iterable[str]) -> tuple[str, str]:
    """Message and hint for a package that building needs, and that is nowhere."""
    if is_cpp(name):
        return (
            f"{name} has no wheel: C++ nodes need an installation of ROS 2",
            f"build this package where ROS 2 is installed (apt install {debian(name)})",
        )
    message = f"package '{name}' is neither in the workspace nor in the environment"
    if hint := absent_ros.hint_for(name):
        return message, hint
    commands = clone_commands(name)
    if commands:
        return message, f"get its sources, in the workspace's folder: {' && '.join(commands)}"
    if has_wheel(name):
        return message, f"install its wheel: pip install {wheel(name)}"
    if is_of_launcher(name):
        return message, "leave it out: launch files need only the launcher, not this package"
    if needs_ros(name):
        return message, f"it has no wheel, but comes with an installation of ROS 2 ({debian(name)})"
    similar = did_you_mean(name, sorted(known))
    sources = "put its sources into src/, or install its wheel if it has one"
    return message, similar or f"{sources}: pip install {wheel(name)}"
