"""Errors about packages and executables that are not found."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence

from launcher.base import text_file
from launcher.base.errors import PackageNotFoundError
from launcher.base.program import program
from launcher.base.text import did_you_mean
from launcher.packages import absent_ros, source_packages, unbuilt
from launcher.packages.package_origins import (
    build_command,
    clone_commands,
    debian,
    has_wheel,
    needs_ros,
    wheel,
)
from launcher.packages.source_packages import MARKERS, OVERLAY_FOLDER

# Packages of programs that verbs replace.
_REPLACED = {"foxglove_bridge": "foxglove", "tf2_tools": "tf tree"}


def package_not_found(
    name: str, known: Iterable[str], prefixes: Sequence[os.PathLike[str]]
) -> PackageNotFoundError:
    """The error, with the nearest name, or where the package comes from."""
    if name in _REPLACED:
        hint: str | None = f"`{program()} {_REPLACED[name]}` does the same, without this package"
    elif is_without_ros := absent_ros.hint_for(name):
        hint = is_without_ros
    elif clone_commands(name):
        steps = build_command(name)
        hint = f"it has no wheel; build it from its sources, in a workspace: {steps}"
    elif has_wheel(name):
        hint = f"install its wheel: pip install {wheel(name)}"
    elif needs_ros(name):
        hint = (
            "it has no wheel, but comes with an installation of ROS 2 "
            f"(apt install {debian(name)}): source its setup.bash; `{program()}` runs there as well"
            + (f"; `{program()} tf` has its programs" if name == "tf2_ros" else "")
        )
    else:
        hint = (
            _lost_hint(name, prefixes)
            or _manifest_hint(name)
            or did_you_mean(name, sorted(known))
            or _searched(prefixes)
        )
    return PackageNotFoundError(f"package '{name}' not found", hint=hint)


def _lost_hint(name: str, prefixes: Iterable[os.PathLike[str]]) -> str | None:
    """Why a package that is installed as links is not found: what they lead to is gone."""
    for prefix in prefixes:
        marker = os.path.join(prefix, MARKERS, name)
        if os.path.islink(marker):
            return (
                f"it is installed in {prefix}, as links to {os.path.realpath(marker)}, which is "
                f"gone: put the source back, or remove what is installed; `{program()} doctor` "
                "names the command"
            )
    return None


def _searched(prefixes: Iterable[os.PathLike[str]]) -> str:
    shown = (path for path in map(str, prefixes) if OVERLAY_FOLDER not in path)
    places = "editable installations, and source folders around the working directory"
    return f"searched: {', '.join(shown)}, {places}"


def _manifest_hint(name: str) -> str | None:
    """What is wrong with the package.xml of a source folder that is called like the package."""
    folder = source_packages.without_name(name)
    if folder is None:
        return None
    file = os.path.join(folder, "package.xml")
    if not os.path.isfile(file):
        return f"{folder}/ has no package.xml"
    from xml.etree import ElementTree

    try:
        ElementTree.fromstring(text_file.read_bytes(file))
    except (ElementTree.ParseError, OSError) as error:
        return f"{file} could not be read: {error}"
    return f"{file} has no <name>"


def no_executable_hint(
    package: str, names: Iterable[str], source: str | None, problem: str | None
) -> str:
    """What a package has instead, or why a source folder has nothing."""
    listed = ", ".join(sorted(names))
    if listed or source is None:
        return f"executables of {package}: {listed or 'none'}"
    if problem is not None:
        return f"{source}/setup.py could not be read: {problem}"
    if os.path.isfile(os.path.join(source, "CMakeLists.txt")):
        return f"{source} is {unbuilt.remedy(package, source)}"
    return f"{source}/setup.py has no console_scripts in its entry_points"
