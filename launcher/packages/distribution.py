"""Which ROS 2 is in use: the wheels in the environment of this Python, or an installation.

This module is on the way to the first process of every launch: it looks at a few files.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping

from launcher.base.model.record import Record

# The distributions by the first number of the version of rclpy.
NAMES = {"3": "humble", "4": "iron", "7": "jazzy", "9": "kilted", "10": "lyrical"}
WHEEL_MACHINES = ("x86_64",)  # for which the index has wheels
DEFAULT = "jazzy"  # whose packages hints name where there is no ROS 2
EXTRAS = ("jazzy", "kilted")  # those with wheels; the extras of this package with these names
ROS_VARIABLES = ("ROS_DISTRO", "ROS_PYTHON_VERSION", "ROS_VERSION")


class RosInUse(Record):
    """The rclpy that nodes import; `name` is None for an unknown distribution."""

    name: str | None
    version: str  # of rclpy
    prefix: str

    @property
    def is_wheels(self) -> bool:
        return bool(_wheel_files(self.prefix, "ros_rclpy-"))


def installed(environ: Mapping[str, str] = os.environ) -> str | None:
    """The distribution in use, in lower case; that of ROS_DISTRO where none is found."""
    found = find(environ)
    return (found and found.name) or environ.get("ROS_DISTRO") or None


def of_version(version: str) -> str | None:
    """The distribution of a version of rclpy."""
    return NAMES.get(version.partition(".")[0].strip())


def or_default(environ: Mapping[str, str] = os.environ) -> str:
    """The distribution whose packages a hint names."""
    return installed(environ) or DEFAULT


def with_wheels(environ: Mapping[str, str] = os.environ) -> str:
    """The extra of this package with the wheels of the distribution in use, else of the default."""
    name = installed(environ)
    return name if name in EXTRAS else DEFAULT


def has_fast_dds_3(environ: Mapping[str, str] = os.environ) -> bool:
    """From Kilted on; names of variables and tags of profiles are not those of Fast DDS 2."""
    found = find(environ)
    first = found.version.partition(".")[0] if found is not None else ""
    return first.isdigit() and int(first) >= 9


def profiles_variable(environ: Mapping[str, str] = os.environ) -> str:
    """What names a file of profiles; Fast DDS 3 warns of the older name."""
    return f"{'FASTDDS' if has_fast_dds_3(environ) else 'FASTRTPS'}_DEFAULT_PROFILES_FILE"


def find(environ: Mapping[str, str] = os.environ) -> RosInUse | None:
    """The first prefix with rclpy, that of this Python last, as when it is imported."""
    for prefix in (*environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix):
        text = _read(f"{prefix}/share/rclpy/package.xml") if prefix else None
        if text is not None:
            version = text.partition("<version>")[2].partition("<")[0].strip()
            name = _of_place(prefix) or of_version(version) or _of_wheels(prefix)
            return RosInUse(name, version, prefix)
    return None


def title(environ: Mapping[str, str] = os.environ) -> str:
    """For users: `ROS 2 Kilted, from /opt/ros/kilted`, or `no ROS 2`."""
    found = find(environ)
    if found is None:
        return "no ROS 2"
    name = f"ROS 2 {found.name.title()}" if found.name else f"ROS 2 with rclpy {found.version}"
    return f"{name}, from {'wheels' if found.is_wheels else found.prefix}"


def conflict(environ: Mapping[str, str] = os.environ) -> str | None:
    """What does not fit together: ROS_DISTRO, the prefix that was found, and Python's rclpy."""
    found, named = find(environ), environ.get("ROS_DISTRO")
    if found is None:
        return None
    if named and found.name and named != found.name:
        return f"ROS_DISTRO is {named}, but the rclpy in {found.prefix} is of {found.name}"
    from importlib.util import find_spec

    spec = find_spec("rclpy")
    place = os.path.dirname(spec.origin) if spec is not None and spec.origin else None
    if place and not os.path.realpath(place).startswith(f"{os.path.realpath(found.prefix)}/"):
        return f"packages are those of {found.prefix}, but Python imports rclpy from {place}"
    return None


def source_installation() -> None:
    """Set what sourcing the set-up file of ROS sets, for launch files and all that is started.

    The wheels install the ament index below `sys.prefix` and set no variable (CONFORMANCE 4.23).
    Those that are set are not changed.
    """
    is_set = os.environ.get("AMENT_PREFIX_PATH", "").strip(os.pathsep)
    if not is_set and os.path.isdir(f"{sys.prefix}/share/ament_index/resource_index/packages"):
        os.environ["AMENT_PREFIX_PATH"] = sys.prefix
    if not all(map(os.environ.__contains__, ROS_VARIABLES)):
        for name, value in ros_variables(os.environ).items():
            os.environ.setdefault(name, value)


def ros_variables(environ: Mapping[str, str]) -> dict[str, str]:
    """The variables that name the ROS in use; none if there is none, or no `ROS_DISTRO` of an
    unknown one.
    """
    found = find(environ)
    if found is None:
        return {}
    named = {"ROS_DISTRO": found.name} if found.name else {}
    return {**named, "ROS_VERSION": "2", "ROS_PYTHON_VERSION": "3"}


def _of_place(prefix: str) -> str | None:
    """By what the package ros_environment of the prefix sets, else by `/opt/ros/NAME`."""
    for suffix in (".dsv", ".sh"):  # `set;ROS_DISTRO;NAME`, `export ROS_DISTRO=NAME`
        hook = _read(f"{prefix}/share/ros_environment/environment/1.ros_distro{suffix}") or ""
        value = hook.partition("ROS_DISTRO")[2][1:].split(maxsplit=1)[:1]
        if value and (name := value[0].strip("\"'")).isidentifier():
            return name
    above, name = os.path.split(prefix.rstrip("/"))
    return name if above.endswith("/opt/ros") else None


def _of_wheels(prefix: str) -> str | None:
    """By the wheel ros-NAME-rclpy, which requires that of rclpy."""
    files = _wheel_files(prefix, "ros_", "_rclpy-")
    names = {file.split("_")[1] for file in files if not file.startswith("ros_rclpy-")}
    return names.pop() if len(names) == 1 else None


def _wheel_files(prefix: str, start: str, part: str = "") -> list[str]:
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    try:
        files = os.listdir(f"{prefix}/lib/{version}/site-packages")
    except OSError:
        return []
    return [
        file
        for file in files
        if file.startswith(start) and part in file and file.endswith(".dist-info")
    ]


def _read(path: str) -> str | None:
    try:
        with open(path, encoding="utf-8") as file:
            return file.read()
    except (OSError, ValueError):
        return None
