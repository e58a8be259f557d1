"""Installations of ROS 2, as in /opt/ros/jazzy and as by pixi, made of the files of the wheels.

Nothing of pip is in them: no metadata of distributions, no hook that Python runs when it starts.
As in /opt/ros, `setup.sh` of an `Installation` sets the paths, and Python is another one, with the
packages of the system beside. The prefix of a `PixiEnvironment` has Python and all packages.
"""

from __future__ import annotations

import os
import shutil
import sys
import venv
from importlib import metadata
from pathlib import Path

from launcher.packages.distribution import or_default
from tests.support.repository import REPOSITORY

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
export ROS_DISTRO={distro} ROS_VERSION=2 ROS_PYTHON_VERSION=3
unset -f _add
unset _prefix _value
"""


class Installation:
    """`setup` is the file to source."""

    def __init__(self, folder: Path) -> None:
        self.prefix = folder / "opt/ros" / or_default()
        self._system = folder / "usr/lib/python3/dist-packages"
        _copy_ros(self.prefix)
        for distribution in metadata.distributions():
            if _name(distribution) in _OF_THE_SYSTEM:
                _copy(distribution, self._system, folder / "usr")
        self.setup = self.prefix / "setup.sh"
        paths = {"prefix": self.prefix, "system": self._system}
        text = _SETUP.format(**paths, version=_VERSION, distro=or_default())
        self.setup.write_text(text, encoding="utf-8")
        shutil.copy(self.setup, self.prefix / "local_setup.sh")


class PixiEnvironment:
    """`setup` stands for the activation, `python` is that of the prefix.

    The launcher and the packages of its extras are there, too.
    """

    def __init__(self, folder: Path) -> None:
        self.prefix = folder / ".pixi/envs/default"
        self.python = with_launcher(self.prefix)
        _copy_ros(self.prefix)
        self.setup = folder / "activate.sh"
        # What the libraries are linked with there.
        text = f"export LD_LIBRARY_PATH={self.prefix}/lib AMENT_PREFIX_PATH={self.prefix}\n"
        self.setup.write_text(f"{text}export PATH={self.prefix}/bin:$PATH\n", encoding="utf-8")


def with_launcher(prefix: Path) -> Path:
    """The Python of a new environment, as after `pip install ros2-launcher[all]`."""
    venv.create(prefix, symlinks=True)
    site = prefix / "lib" / _VERSION / "site-packages"
    for distribution in metadata.distributions():
        is_pip = distribution.read_text("RECORD") is not None  # the wheels have more metadata
        if is_pip and not _name(distribution).startswith("ros-"):
            _copy(distribution, site, prefix, is_whole=True)
    for path in [*site.glob("__editable__*"), *site.glob("group_gp1*")]:
        path.unlink() if path.is_file() else shutil.rmtree(path)
    (site / "launcher").symlink_to(REPOSITORY / "launcher")
    return prefix / "bin/python"


def _name(distribution: metadata.Distribution) -> str:
    return (distribution.metadata["Name"] or "").lower().replace("_", "-")


def _copy_ros(prefix: Path) -> None:
    site = prefix / "lib" / _VERSION / "site-packages"
    for distribution in metadata.distributions():
        if _name(distribution).startswith("ros-") and "bootstrapper" not in _name(distribution):
            _copy(distribution, site, prefix)
    for library in site.glob("ros_*.libs/*"):
        _place(library, prefix / "lib" / library.name)


def _copy(
    distribution: metadata.Distribution, site: Path, prefix: Path, *, is_whole: bool = False
) -> None:
    """Its files, those of Python to `site`, others to `prefix`.

    Metadata and scripts only if it `is_whole`; these get the Python of the prefix.
    """
    own_site = Path(os.path.normpath(str(distribution.locate_file(""))))
    for file in distribution.files or ():
        source = Path(os.path.normpath(str(distribution.locate_file(file))))
        if "__pycache__" in file.as_posix() or (".dist-info/" in file.as_posix() and not is_whole):
            continue
        if source.is_relative_to(own_site):
            target = site / source.relative_to(own_site)
        else:
            target = prefix / source.relative_to(sys.prefix)
        if source.is_file() and (is_whole or source.parent.name != "bin"):
            _place(source, target)
            _adapt(target, prefix)


def _adapt(script: Path, prefix: Path) -> None:
    """Give a script of pip the Python of the prefix."""
    first = f"#!{sys.prefix}/".encode()
    if script.parent.name == "bin" and (text := script.read_bytes()).startswith(first):
        mode = script.stat().st_mode
        script.unlink()  # it may be the file of the other environment itself
        script.write_bytes(text.replace(first, f"#!{prefix}/".encode(), 1))
        script.chmod(mode)


def _place(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    if target.exists():
        return
    try:
        os.link(source, target)
    except OSError:
        shutil.copy2(source, target)
