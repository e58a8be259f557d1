"""Hosts to synchronize without ssh: a shell of this machine with a separate home."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from launcher.base.errors import LauncherError
from launcher.hosts.file.hosts_model import Host
from launcher.hosts.sync.fleet_sync import FleetSync, Result
from launcher.hosts.sync.host_sync import SyncOptions, SyncOutcome
from launcher.hosts.sync.pinned_list import PinnedList
from launcher.hosts.sync.release_tree import TreeEntry
from launcher.hosts.sync.synced_packages import Brought

WORKSPACE = ".local/share/launcher/workspace"
# Not that of an environment, so that one is made.
PLAIN_PYTHON = os.path.join(sys.base_prefix, "bin", f"python3.{sys.version_info[1]}")


class Site:
    """A host with its home, and what its messages say."""

    def __init__(self, home: Path, **settings: Any) -> None:
        home.mkdir(parents=True)
        self.home = home
        self.host = Host(
            name=home.name, address=home.name, **{"python": sys.executable, **settings}
        )
        self.messages: list[str] = []

    @property
    def workspace(self) -> Path:
        return self.home / self.host.workspace

    @property
    def current(self) -> Path:
        return self.workspace / "current"

    @property
    def release(self) -> str:
        """The name of the release in use."""
        return os.path.basename(os.readlink(self.current))

    @property
    def releases(self) -> list[str]:
        return sorted(
            path.name for path in (self.workspace / "releases").iterdir() if path.name[0] != "."
        )

    def words(self, host: Host, script: str) -> Sequence[str]:
        clean = ["env", "-i", f"HOME={self.home}", "PATH=/usr/bin:/bin", "LANG=C.UTF-8"]
        return [*clean, "sh", "-c", script]

    def fleet(self, **options: Any) -> FleetSync:
        return FleetSync(
            SyncOptions(**options), lambda _, text: self.messages.append(text), self.words
        )

    def sync(self, brought: Brought, **options: Any) -> SyncOutcome:
        """Synchronize; the error is raised."""
        return self._only(self.fleet(**options).sync([self.host], brought))

    def roll_back(self, **options: Any) -> SyncOutcome:
        return self._only(self.fleet(**options).roll_back([self.host]))

    def run(self, *words: str, **variables: str) -> str:
        """What the Python of the release prints."""
        done = subprocess.run(
            [str(self.current / "bin/python"), *words],
            env={"HOME": str(self.home), "PATH": "/usr/bin:/bin", **variables},
            cwd=self.home,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=60,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    @staticmethod
    def _only(results: list[Result]) -> SyncOutcome:
        (result,) = results
        if isinstance(result, SyncOutcome):
            return result
        raise result


def brought(**files: str | bytes) -> Brought:
    """A release of files by their path; `__` stands for `/`."""
    found = Brought()
    for name, text in files.items():
        content = text if isinstance(text, bytes) else text.encode()
        found.tree.add(TreeEntry(path=name.replace("__", "/"), content=content))
    return found


def tiny_wheel(folder: Path, name: str, version: str, tag: str = "py3-none-any") -> Path:
    """A wheel of one module, which has its version."""
    folder.mkdir(exist_ok=True)
    path = folder / f"{name}-{version}-{tag}.whl"
    info = f"{name}-{version}.dist-info"
    texts = {
        f"{name}.py": f"VERSION = {version!r}\n",
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n",
        f"{info}/WHEEL": f"Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: {tag}\n",
    }
    record = "".join(f"{file},,\n" for file in (*texts, f"{info}/RECORD"))
    with zipfile.ZipFile(path, "w") as wheel:
        for file, text in {**texts, f"{info}/RECORD": record}.items():
            wheel.writestr(file, text)
    return path


def pinned(*lines: str) -> PinnedList:
    return PinnedList(text="".join(f"{line}\n" for line in lines), where="list.txt")


def fails(site: Site, files: Brought, **options: Any) -> LauncherError:
    with pytest.raises(LauncherError) as caught:
        site.sync(files, **options)
    return caught.value
