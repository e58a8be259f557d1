"""Environments of Python with the ROS wheels of the running one, made in a second."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import venv
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Environment:
    """A virtual environment into which pip can install; nothing leads to the running one."""

    prefix: Path

    @property
    def python(self) -> Path:
        return self.prefix / "bin/python"

    @property
    def variables(self) -> dict[str, str]:
        """The variables of a shell without ROS."""
        names = ("PYTHONPATH", "LD_LIBRARY_PATH", "AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH")
        dropped = {*names, "_ROS_WHEELS_BOOTSTRAP_COMPLETE", "PYTHONHOME", "VIRTUAL_ENV"}
        # The Makefile's files of pip are relative to the checkout.
        dropped |= {"PIP_CONSTRAINT", "PIP_BUILD_CONSTRAINT"}
        return {name: value for name, value in os.environ.items() if name not in dropped}

    def pip(self, *words: str) -> str:
        """What pip prints; it has no network."""
        command = [sys.executable, "-m", "pip", "--python", str(self.python), *words]
        return self._output(command)

    def run(self, *words: str, cwd: Path | None = None, **variables: str) -> str:
        """What the Python of the environment prints."""
        return self._output([str(self.python), *words], cwd, variables)

    def files(self) -> set[str]:
        """All files, without what Python compiles."""
        return {
            os.path.relpath(os.path.join(folder, name), self.prefix)
            for folder, _, names in os.walk(self.prefix)
            for name in names
            if "__pycache__" not in folder
        }

    def _output(
        self, command: list[str], cwd: Path | None = None, variables: dict[str, str] | None = None
    ) -> str:
        done = subprocess.run(
            command,
            cwd=cwd or self.prefix,
            env={**self.variables, **(variables or {})},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=300,
        )
        assert done.returncode == 0, f"{command}: {done.returncode}\n{done.stdout}{done.stderr}"
        return done.stdout


def environment_with_ros(prefix: Path) -> Environment:
    """A new environment with links to all distributions of the running one but our own.

    Folders into which pip installs are real ones, so nothing is written into the running one.
    """
    venv.create(prefix, symlinks=True)
    site = Path(sysconfig.get_path("purelib"))
    here = Path(sys.prefix)
    _link_all(site, prefix / site.relative_to(here))
    _link_all(here / "lib", prefix / "lib")
    _link_all(here / "include", prefix / "include")
    _link_tree(here / "share/ament_index", prefix / "share/ament_index")
    _link_all(here / "share", prefix / "share")
    return Environment(prefix)


def _link_all(source: Path, target: Path) -> None:
    target.mkdir(parents=True, exist_ok=True)
    for path in source.iterdir():
        link = target / path.name
        if not link.exists() and not path.name.startswith(
            ("group_gp1", "ros2_launcher", "__editable__")
        ):
            link.symlink_to(path)


def _link_tree(source: Path, target: Path) -> None:
    target.mkdir(parents=True)
    for path in source.iterdir():
        if path.is_dir():
            _link_tree(path, target / path.name)
        else:
            (target / path.name).symlink_to(path)
