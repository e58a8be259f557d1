"""The contents of the wheel of a Python package: its sources as setuptools packs them."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable
from email import message_from_bytes
from importlib import metadata
from pathlib import Path

from launcher.base.errors import LauncherError
from launcher.packages.extras import install_command
from launcher.workspace.building.sources import Package
from launcher.workspace.building.sources.source_text import shown
from launcher.workspace.building.wheel.archive import WheelEntry
from launcher.workspace.building.wheel.contents import WheelContents

# `__legacy__` works with and without pyproject.toml; the folder of setup.py is on sys.path.
_BUILD = "import sys; from setuptools.build_meta import __legacy__ as b; b.build_wheel(sys.argv[1])"
_MARKS = ("COLCON_IGNORE", "pyvenv.cfg")  # of build/, install/ and log/, and of environments


def contents(package: Package) -> tuple[WheelContents, tuple[str, ...]]:
    """The files of the wheel, and the requirements that setup.py names; LauncherError.

    In a workspace the files are links to the sources, so the sources are packed, in a copy without
    what was built in them.
    """
    with tempfile.TemporaryDirectory(prefix="launcher-") as folder:
        copy, target = os.path.join(folder, "sources"), os.path.join(folder, "wheel")
        ignored = _no_sources(package.folder)
        try:
            shutil.copytree(package.folder, copy, ignore=ignored, ignore_dangling_symlinks=True)
        except shutil.Error as error:
            path, _, problem = error.args[0][0]
            raise LauncherError(f"cannot be copied: {problem}", where=shown(path)) from None
        os.mkdir(target)
        done = subprocess.run(
            [sys.executable, "-c", _BUILD, target],
            cwd=copy,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
        )
        made = list(Path(target).glob("*.whl"))
        if "invalid command 'bdist_wheel'" in done.stderr:
            raise LauncherError(
                f"setuptools {metadata.version('setuptools')} cannot make a wheel of "
                f"{package.name}: it is older than 70.1, and the package `wheel` is not installed",
                hint=f"install what is needed: {install_command('build')}",
            )
        if done.returncode or not made:
            said = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
            raise LauncherError(
                f"setuptools cannot make a wheel of {package.name}: {said[-1]}",
                where=shown(package.file("setup.py")),
            )
        return _read(made[0])


def _no_sources(top: str) -> Callable[[str, list[str]], list[str]]:
    """For `copytree`: what tools have built or keep in the folder."""

    def ignored(folder: str, names: list[str]) -> list[str]:
        return [
            name
            for name in names
            if name in ("__pycache__", ".git")
            or name.endswith(".egg-info")
            or (folder == top and name in ("build", "dist"))
            or any(os.path.exists(os.path.join(folder, name, one)) for one in _MARKS)
        ]

    return ignored


def _read(path: Path) -> tuple[WheelContents, tuple[str, ...]]:
    stem = "-".join(path.name.split("-")[:2])
    modules, data = [], []
    entry_points, requirements = "", tuple[str, ...]()
    with zipfile.ZipFile(path) as wheel:
        for info in wheel.infolist():
            if info.is_dir():
                continue
            content = wheel.read(info)
            folder, _, inside = info.filename.partition("/")
            if folder == f"{stem}.dist-info":
                if inside == "METADATA":
                    requirements = tuple(message_from_bytes(content).get_all("Requires-Dist", ()))
                elif inside == "entry_points.txt":
                    entry_points = content.decode()
                continue
            is_executable = bool(info.external_attr >> 16 & 0o111)
            if folder == f"{stem}.data":
                scheme, _, inside = inside.partition("/")
                where = {"data": "", "scripts": "bin/", "headers": "include/"}.get(scheme)
                if where is not None:
                    data.append(WheelEntry(where + inside, content, is_executable))
                    continue
            else:
                inside = info.filename
            modules.append(WheelEntry(inside, content, is_executable))
    python = f"{sys.version_info[0]}.{sys.version_info[1]}"
    is_native = any(one.name.endswith(".so") for one in modules)
    found = WheelContents(tuple(modules), tuple(data), python if is_native else None, entry_points)
    return found, requirements
