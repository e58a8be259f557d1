"""Workspaces that define interfaces, built once for all workers of a test run."""

from __future__ import annotations

import fcntl
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from launcher.packages.environment import environment
from launcher.packages.workspace import Workspace
from tests.support.repository import REPOSITORY
from tests.support.verbs import Answer

EXAMPLE = REPOSITORY / "examples/fleet_workspace"
TYPE_MATRIX = REPOSITORY / "tests/support/type_matrix"  # interfaces with fields of every kind
TRANSFORM_TYPES = REPOSITORY / "tests/support/transform_types"  # tf2_msgs with its one message
BUILD_TIMEOUT_S = 500.0
# Others import from the same folders, and rename what they have compiled while it is copied.
COMPILED = shutil.ignore_patterns("__pycache__")


@dataclass(frozen=True, slots=True, kw_only=True)
class BuiltWorkspace:
    """A workspace after `launcher build`; tests that change files take a copy of its sources."""

    root: Path

    @property
    def install(self) -> Path:
        return self.root / "install"

    def environment(self, env: Mapping[str, str]) -> dict[str, str]:
        """The variables with which a program that is not the launcher uses the workspace."""
        return environment(Workspace(str(self.root), str(self.install)), env)


def shared_folder(base: Path) -> Path:
    """The folder that all workers share; `base` is pytest's for this worker."""
    return base.parent if "PYTEST_XDIST_WORKER" in os.environ else base


def copy_sources(packages: Path, workspace: Path) -> None:
    """Make `workspace/src` with the packages of a folder, without what tools left in them."""
    leftovers = shutil.ignore_patterns("__pycache__", "*.egg-info", ".pytest_cache", "build")
    shutil.copytree(packages, workspace / "src", ignore=leftovers)


def built_once(base: Path, name: str, packages: Path, *words: str) -> BuiltWorkspace:
    """The workspace `name` with the packages of a folder; the first worker of a run builds it."""
    shared = shared_folder(base)
    root = shared / name
    done = shared / f"{name}.done"
    with open(shared / f"{name}.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not done.exists():
            shutil.rmtree(root, ignore_errors=True)
            copy_sources(packages, root)
            build(root, *words)
            done.touch()
    return BuiltWorkspace(root=root)


def example(base: Path, compiler: str = "system") -> BuiltWorkspace:
    """`EXAMPLE`, built once by this compiler; tests only read it."""
    return built_once(base, f"fleet_{compiler}", EXAMPLE / "src", "--compiler", compiler)


def build(root: Path, *words: str, env: Mapping[str, str] | None = None) -> str:
    """`launcher build WORDS` in a workspace; what it printed."""
    return run([sys.executable, "-m", "launcher", "build", *words], cwd=root, env=env)


def launcher(folder: Path, *words: str, **variables: str) -> Answer:
    """`python -m launcher WORDS` in a folder, with time for a build."""
    done = subprocess.run(
        [sys.executable, "-m", "launcher", *words],
        cwd=folder,
        env={**os.environ, **variables},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=BUILD_TIMEOUT_S,
    )
    return Answer(out=done.stdout, err=done.stderr, code=done.returncode)


def run(command: Sequence[str], *, cwd: Path, env: Mapping[str, str] | None = None) -> str:
    """The output of a command that succeeds."""
    done = subprocess.run(
        command,
        cwd=cwd,
        env=dict(os.environ if env is None else env),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=BUILD_TIMEOUT_S,
    )
    assert done.returncode == 0, f"{command}: exit code {done.returncode}\n{done.stdout}"
    return done.stdout
