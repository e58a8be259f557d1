"""Podman with a separate store, and the image that an exported recipe builds."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.hosts.requirements import program, why_no_hosts
from tests.support.hosts.tool import failure
from tests.support.hosts.tree import NoTreeError, tree
from tests.support.repository import REPOSITORY
from tests.support.workspaces import COMPILED

_PROGRAMS = ("podman", "runc", "catatonit", "mmdebstrap")
_BUILD_TIMEOUT_S = 500.0
# crun refuses the hybrid control groups that the machine may have; the soft limits of a process
# cannot be above the hard ones of the machine.
_SETTINGS = """
[containers]
default_ulimits=["nofile=4096:4096", "nproc=4096:4096"]
[engine]
runtime="runc"
cgroup_manager="cgroupfs"
events_logger="file"
"""


def needs_podman() -> None:
    """Skip the test where containers cannot be run."""
    missing = [name for name in _PROGRAMS if program(name) is None]
    reason = why_no_hosts() or (f"not installed: {', '.join(missing)}" if missing else "")
    if reason:
        pytest.skip(reason)


class Podman:
    """Containers and images below `folder`; `close` removes all.

    The host of the containers is the network namespace at `network`. (`ip netns exec` would hide
    the control groups.)
    """

    def __init__(self, folder: Path, network: Path | str) -> None:
        self.folder = folder
        folder.mkdir(parents=True)
        (folder / "containers.conf").write_text(_SETTINGS)
        self.command = folder / "podman"
        roots = f"--root {folder}/store --runroot {folder}/run"
        words = f"nsenter --net={network} {program('podman')} {roots}"
        self.command.write_text(f'#!/bin/sh\nexec {words} "$@"\n')
        self.command.chmod(0o755)
        self.env = {**os.environ, "CONTAINERS_CONF": str(folder / "containers.conf")}

    def run(
        self, *words: str | Path, check: bool = True, cwd: Path | None = None
    ) -> subprocess.CompletedProcess[str]:
        command = [str(word) for word in (self.command, *words)]
        done = subprocess.run(
            command,
            env=self.env,
            cwd=cwd,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=_BUILD_TIMEOUT_S,
        )
        assert not check or done.returncode == 0, failure(command, done)
        return done

    def logs(self, name: str) -> str:
        """The lines of the container whose name ends like this."""
        names = self.run("ps", "--all", "--format", "{{.Names}}").stdout.split()
        found = [one for one in names if re.search(rf"(^|[-_]){name}(_1)?$", one)]
        return "".join(self.run("logs", one).stdout for one in found[-1:])

    def close(self) -> None:
        self.run("pod", "rm", "--all", "--force", "--time", "0", check=False)
        self.run("rm", "--all", "--force", "--time", "0", check=False)
        subprocess.run(["umount", self.folder / "store" / "overlay"], capture_output=True)
        shutil.rmtree(self.folder, ignore_errors=True)

    def build(self, context: Path, name: str) -> None:
        """Build the image of an export, from wheels only and without a registry."""
        self._make_base(context / "Containerfile")
        _collect_wheels(context)
        self.run("build", "--network", "none", "--build-arg", "PIP_NO_INDEX=1", "-t", name, context)

    def _make_base(self, recipe: Path) -> None:
        """A Debian with Python under the name that the recipe begins with."""
        (name,) = re.findall(r"^FROM (\S+)$", recipe.read_text(), re.MULTILINE)
        try:
            folder = tree()
        except NoTreeError as error:
            pytest.skip(str(error))
        version = f"python{sys.version_info.major}.{sys.version_info.minor}"
        if not (folder / "usr" / "bin" / version).exists():
            pytest.skip(f"the machine's distribution has no {version}, for which the wheels are")
        archive = self.folder / "base.tar"
        subprocess.run(["tar", "-C", folder, "-cf", archive, "."], check=True)
        self.run("import", archive, f"docker.io/library/{name}")
        archive.unlink()


def _collect_wheels(context: Path) -> None:
    """The packages of the recipe and the launcher itself, as its README says."""
    wheels, sources = context / "wheels", _sources(context)
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--wheel-dir", str(wheels)]
    for words in (
        ["--requirement", str(context / "requirements.txt")],
        ["--no-deps", f"{sources}/launcher", str(sources)],
    ):
        done = subprocess.run(
            [*pip, *words], capture_output=True, text=True, timeout=_BUILD_TIMEOUT_S
        )
        if done.returncode:
            pytest.skip(f"pip cannot get the packages of the image: {done.stderr.strip()[-200:]}")


def _sources(context: Path) -> Path:
    """A copy of the checkout: pip would write into it."""
    folder = context.parent / "sources"
    names = ("launcher", "group_gp1", "launch", "resource")
    for name in names:
        shutil.copytree(REPOSITORY / name, folder / name, ignore=COMPILED, dirs_exist_ok=True)
    for name in ("setup.py", "setup.cfg", "pyproject.toml", "package.xml", "README.md"):
        shutil.copy(REPOSITORY / name, folder)
    return folder
