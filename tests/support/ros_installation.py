"""An installation of ROS 2 as in /opt/ros/jazzy, made of the files of the wheels.

Nothing of pip is in it: no metadata of distributions, no hook that Python runs when it starts. As
there, `setup.sh` sets the paths, and Python is another one, with the packages of the system beside.
"""

from __future__ import annotations

import os
import shutil
import sys
from importlib import metadata
from pathlib import Path

# Of Debian's and Ubuntu's packages, which those of ROS depend on.
_OF_THE_SYSTEM = ("numpy", "psutil", "pyyaml", "lark-parser", "empy", "packaging", "setuptools")
_VERSION = f"python{sys.version_info[0]}.{sys.version_info[1]}"
_SETUP = """\
# generated, as by colcon
_prefix={prefix}
_add() {{ eval "_value=\\"\\${{$1:-}}\\""; eval "export $1=\\"$2${{_value:+:$_value}}\\""; }}
_add AMENT_PREFIX_PATH "$_prefix"
_add PYTHONPATH {system}
_add PYTHONPATH "$_prefix/lib/{version}/site-packages"
_add LD_LIBRARY_PATH "$_prefix/lib"
_add PATH "$_prefix/bin"
export ROS_DISTRO=jazzy ROS_VERSION=2 ROS_PYTHON_VERSION=3
unset -f _add
unset _prefix _value
"""


class Installation:
    """`setup` is the file to source."""

    def __init__(self, folder: Path) -> None:
        self.prefix = folder / "opt/ros/jazzy"
        self._system = folder / "usr/lib/python3/dist-packages"
        for distribution in metadata.distributions():
            name = (distribution.metadata["Name"] or "").lower()
            if name.startswith("ros-") and name != "ros-wheels-bootstrapper":
                _copy(distribution, self.prefix / "lib" / _VERSION / "site-packages", self.prefix)
            elif name in _OF_THE_SYSTEM:
                _copy(distribution, self._system, folder / "usr")
        for library in (self.prefix / "lib" / _VERSION / "site-packages").glob("ros_*.libs/*"):
            _place(library, self.prefix / "lib" / library.name)
        self.setup = self.prefix / "setup.sh"
        text = _SETUP.format(prefix=self.prefix, system=self._system, version=_VERSION)
        self.setup.write_text(text, encoding="utf-8")
        shutil.copy(self.setup, self.prefix / "local_setup.sh")


def _copy(distribution: metadata.Distribution, site: Path, prefix: Path) -> None:
    """Its files without metadata and scripts; those of Python go to `site`, others to `prefix`."""
    own_site = Path(os.path.normpath(str(distribution.locate_file(""))))
    for file in distribution.files or ():
        source = Path(os.path.normpath(str(distribution.locate_file(file))))
        if ".dist-info/" in file.as_posix() or "__pycache__" in file.as_posix():
            continue
        if source.is_relative_to(own_site):
            target = site / source.relative_to(own_site)
        else:
            target = prefix / source.relative_to(sys.prefix)
        if source.is_file() and source.parent.name != "bin":
            _place(source, target)


def _place(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    if target.exists():
        return
    try:
        os.link(source, target)
    except OSError:
        shutil.copy2(source, target)
